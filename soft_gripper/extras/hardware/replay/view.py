"""Shows replays in Meshcat: the measured bodies and the estimated arms, recording after recording."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.geometry import Box, Capsule, Meshcat, Rgba
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.estimate_visualizer import draw_links, put
from soft_gripper.diagrams.view.finger_drawing import estimated_corners

_FRAME_RATE = 20.0  # per second
_ARM_RADIUS, _BODY_EDGE = 0.0035, 0.014  # m, of an estimated arm and edge of a measured body
_GREY, _BLACK = Rgba(0.6, 0.6, 0.6), Rgba(0.1, 0.1, 0.1, 0.8)


def show_replays(meshcat: Meshcat, recordings: Sequence[Recording], colors: Mapping[str, str]) -> None:
    """Records an animation of replays, one after the other, in Meshcat, with colours as #rrggbb by row of estimators.

    The arm hangs: z of B points down. A black box is a body measured by motion capture; a line is an estimate.
    """
    reach = float(np.nanmax(recordings[0]["measured_bodies"].values[1:]))
    _set_scene(meshcat, reach)
    _add_objects(meshcat, recordings[0], colors)
    meshcat.StartRecording(frames_per_second=_FRAME_RATE, set_visualizations_while_recording=False)
    begin = 0.0
    for recording in recordings:
        times = recording.data["time"].values
        stride = max(1, round(1 / (_FRAME_RATE * (times[1] - times[0]))))
        for row in range(1, len(times), stride):
            _pose(meshcat, recording, row, begin + times[row], colors)
        begin += float(times[-1])
    meshcat.StopRecording()
    meshcat.PublishRecording()


def _set_scene(meshcat: Meshcat, reach: float) -> None:
    meshcat.SetProperty("/Background", "top_color", [1, 1, 1])
    meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
    for part in ("/Grid", "/Axes"):
        meshcat.SetProperty(part, "visible", False)
    meshcat.SetCameraPose([0.0, -1.2 * reach, -0.45 * reach], [0.0, 0.0, -0.55 * reach])
    meshcat.SetTransform("replay", RigidTransform(RollPitchYaw(np.pi, 0, 0), np.zeros(3)))
    meshcat.SetObject("replay/base", Box(0.06, 0.06, 0.01), _GREY)
    meshcat.SetTransform("replay/base", RigidTransform([0, 0, -0.005]))


def _add_objects(meshcat: Meshcat, recording: Recording, colors: Mapping[str, str]) -> None:
    for body in range(len(recording["body"])):
        meshcat.SetObject(f"replay/measured/{body}", Box(_BODY_EDGE, _BODY_EDGE, _BODY_EDGE), _BLACK)
    for estimator, color in colors.items():
        rgb = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        steps = np.diff(arm_corners(recording, estimator, len(recording["time"]) // 2), axis=0)
        for link, length in enumerate(np.linalg.norm(steps, axis=-1)):
            meshcat.SetObject(f"{_path(estimator)}/{link}", Capsule(_ARM_RADIUS, float(length)), Rgba(*rgb))


def _pose(meshcat: Meshcat, recording: Recording, row: int, time: float, colors: Mapping[str, str]) -> None:
    bodies: Array = recording["measured_bodies"].values[row]
    for body, position in enumerate(bodies):
        put(meshcat, f"replay/measured/{body}", position, 0.0, time)
    for estimator in colors:
        draw_links(meshcat, _path(estimator), arm_corners(recording, estimator, row), time)


def arm_corners(recording: Recording, estimator: str, row: int) -> Array:
    """Base, joints and last body of an estimated arm at a sample, (N + 2, 3) m in B."""
    joints, bodies = (recording[f"{estimator}.{name}"].values[row] for name in ("joint_positions", "body_positions"))
    return estimated_corners({"joint_positions": joints, "tip_pose": bodies[-1]})


def _path(estimator: str) -> str:
    return f"replay/{estimator.replace(' ', '_')}"
