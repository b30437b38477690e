"""SoftVisualizer: draws soft objects where their vertices are, and a new shape only when they have been deformed."""

from pathlib import Path
from typing import Any

import numpy as np
from drawing import Drawing
from pydrake.geometry import Rgba
from scipy.spatial.transform import Rotation

from soft_gripper.arrays import Array
from soft_gripper.extras import soft
from soft_gripper.extras.soft.soft_visualizer import MIN_CHANGE, SOFT, DrawnBody, SoftVisualizer
from soft_gripper.extras.soft.tetrahedra import read_tetrahedra

REST = read_tetrahedra(Path(soft.__path__[0]) / "objects" / "soft_block.vtk")
MOVED = Rotation.from_rotvec([0.3, -0.5, 0.8]).apply(REST.vertices) + np.array([0.1, 0.2, 0.3])
SQUEEZED = REST.vertices * [0.95, 1.0, 1.0]


class MeshDrawing(Drawing):
    """Keeps triangle meshes, and visibility over time if it records."""

    def __init__(self, is_recording: bool) -> None:
        super().__init__()
        self.is_recording = is_recording
        self.drawn = 0
        self.visible: dict[str, dict[float, bool]] = {}

    def SetTriangleMesh(self, path: str, vertices: Array, faces: Array, rgba: Any) -> None:  # noqa: N802
        self.objects[path] = vertices[:, faces]
        self.drawn += 1

    def SetProperty(self, path: str, name: str, value: Any, time: float | None = None) -> None:  # noqa: N802
        self.visible.setdefault(path, {})[0.0 if time is None else time] = value

    def get_mutable_recording(self) -> None:
        if not self.is_recording:
            raise RuntimeError


def shown(drawing: MeshDrawing, shapes: list[Array]) -> None:
    """Draws one shape after the other, at 0, 1, ... s."""
    visualizer = SoftVisualizer(drawing, [DrawnBody("sponge", REST, Rgba())], period=0.05)
    context = visualizer.CreateDefaultContext()
    visualizer.ExecuteInitializationEvents(context)
    for time, vertices in enumerate(shapes):
        context.SetTime(time)
        visualizer.GetInputPort("sponge.vertices").FixValue(context, vertices.ravel())
        visualizer.ForcedPublish(context)


def test_a_motion_is_drawn_without_a_new_shape_and_a_deformation_with_one():
    slightly = REST.vertices * [1 - 0.9 * MIN_CHANGE / 0.022, 1, 1]
    for shapes, drawn in (([REST.vertices, MOVED, slightly], 1), ([REST.vertices, SQUEEZED], 2)):
        drawing = MeshDrawing(is_recording=False)
        shown(drawing, shapes)
        assert drawing.drawn == drawn
        assert list(drawing.objects) == [f"{SOFT}/sponge/0"]


def test_in_a_recording_each_shape_is_visible_in_its_time():
    drawing = MeshDrawing(is_recording=True)
    shown(drawing, [REST.vertices, SQUEEZED])
    first, second = (drawing.visible[f"{SOFT}/sponge/{number}"] for number in range(2))
    assert first == {0.0: True, 1.0: False}
    assert second == {0.0: False, 1.0: True}
