"""Replays in Meshcat: the measured bodies beside the estimated arms, recording after recording."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.geometry import Box, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.view.planar_pose import rounded

_FRAMES = 20.0  # a second
_JOINT, _BODY = 0.004, 0.012  # m, radius of an estimated point and edge of a measured body
_MEASURED = Rgba(0.1, 0.1, 0.1)


def show_replays(meshcat: Meshcat, recordings: Sequence[Recording], colors: Mapping[str, str]) -> None:
    """Records an animation in Meshcat.

    The arm hangs: z of B points down. A black box is a body where motion capture saw it, a chain of balls an estimate.

    Args:
        meshcat: shows it.
        recordings: of replays; they follow each other in time.
        colors: of the estimators that are drawn, as #rrggbb, by their rows.
    """
    bodies = len(recordings[0]["body"])
    _add_objects(meshcat, recordings[0], bodies, colors)
    reach = float(np.nanmax(recordings[0]["measured_bodies"].values[1:]))
    meshcat.SetCameraPose([0.0, -2.2 * reach, -0.5 * reach], [0.0, 0.0, -0.5 * reach])
    meshcat.StartRecording(frames_per_second=_FRAMES, set_visualizations_while_recording=False)
    begin = 0.0
    for recording in recordings:
        times = recording.data["time"].values
        for row in range(1, len(times), max(1, round(1 / (_FRAMES * (times[1] - times[0]))))):
            _pose(meshcat, recording, row, begin + times[row], colors)
        begin += float(times[-1])
    meshcat.StopRecording()
    meshcat.PublishRecording()


def _add_objects(meshcat: Meshcat, recording: Recording, bodies: int, colors: Mapping[str, str]) -> None:
    meshcat.SetProperty("/Background", "top_color", [1, 1, 1])
    meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetObject("replay/base", Box(0.06, 0.06, 0.01), Rgba(0.5, 0.5, 0.5))
    meshcat.SetTransform("replay/base", RigidTransform([0, 0, 0.005]))
    for body in range(bodies):
        meshcat.SetObject(f"replay/measured/{body}", Box(_BODY, _BODY, _BODY), _MEASURED)
    for row, color in colors.items():
        points = recording[f"{row}.joint_positions"].shape[1] + bodies
        rgb = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        for point in range(points):
            meshcat.SetObject(_path(row, point), Sphere(_JOINT), Rgba(*rgb))


def _pose(meshcat: Meshcat, recording: Recording, row: int, time: float, colors: Mapping[str, str]) -> None:
    for body, place in enumerate(recording["measured_bodies"].values[row]):
        _put(meshcat, f"replay/measured/{body}", place, time)
    for estimator in colors:
        signals = (f"{estimator}.joint_positions", f"{estimator}.body_positions")
        for point, place in enumerate(np.concatenate([recording[signal].values[row] for signal in signals])):
            _put(meshcat, _path(estimator, point), place, time)


def _path(row: str, point: int) -> str:
    return f"replay/{row.replace(' ', '_')}/{point}"


def _put(meshcat: Meshcat, path: str, place: Array, time: float) -> None:
    x, z = (rounded(value) for value in place)
    meshcat.SetProperty(path, "position", [x, 0.0, -z], time)
