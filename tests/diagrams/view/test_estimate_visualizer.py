"""EstimateVisualizer: what it draws where, in which colours, and when."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from drawing import Drawing
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.estimate_visualizer import ARCS, DrawnFinger, EstimateVisualizer
from soft_gripper.diagrams.view.finger_drawing import SHAPES
from soft_gripper.estimators.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.estimators.plane import pose_entries
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

X_WB = RigidTransform(RollPitchYaw(0.3, -0.4, 1.1), [0.1, -0.2, 0.3])
LIMIT = 0.2
NAME = "hand.finger"  # of blocks and signals; the finger itself is called otherwise
IN_PLANE = SHAPES[1]
ROUNDING = 3e-6  # m; poses are rounded to about a micrometre


class Scene:
    """One finger of given readings and torques, drawn once."""

    def __init__(self, layout: SensorLayout, strain: Array, torque: Array, end: float = 0.0):
        builder = DiagramBuilder()
        self.drawing, self.layout = Drawing(), layout
        skin = tuple((f"/link_{i}/box", f"/link_{i}/knuckle") for i in range(layout.finger.segments + 1))
        sizes = dict(zip(IN_PLANE, (2 * layout.finger.segments, 3), strict=True))
        drawn = DrawnFinger(NAME, layout.finger, layout.sections, BodyIndex(2), skin, sizes)
        visualizer = builder.AddSystem(EstimateVisualizer(self.drawing, [drawn], LIMIT, period=0.05))
        pose = builder.AddSystem(ArcPoseEstimator(layout, np.zeros(3)))
        other = RigidTransform([9.0, 9.0, 9.0])
        poses = builder.AddSystem(ConstantValueSource(Value([other, other, X_WB, other])))
        builder.Connect(poses.get_output_port(), visualizer.GetInputPort("body_poses"))
        for vector, port in (
            (strain, pose.GetInputPort("strain")),
            (np.zeros(layout.finger.segments), pose.GetInputPort("driving_torque")),
            (pose_entries(X_WB), pose.GetInputPort("X_WB")),
            (torque, visualizer.GetInputPort(f"{NAME}.external_torque")),
        ):
            builder.Connect(builder.AddSystem(ConstantVectorSource(vector)).get_output_port(), port)
        for port in ("arcs", *IN_PLANE):
            builder.Connect(pose.GetOutputPort(port), visualizer.GetInputPort(f"{NAME}.{port}"))
        self.pose, self.diagram = pose, builder.Build()
        self.simulator = Simulator(self.diagram)
        self.simulator.Initialize()
        self.simulator.AdvanceTo(end)

    def estimate(self, port: str) -> Array:
        context = self.pose.GetMyContextFromRoot(self.simulator.get_context())
        return self.pose.GetOutputPort(port).Eval(context)

    @property
    def arcs(self) -> Array:
        """x, z, heading, kappa, length, centre's x and z of the arcs, (S, 7)."""
        return self.estimate("arcs").reshape(-1, 7)

    def pieces(self) -> list[str]:
        """Paths of the pieces of the curve, each of which has a box on either side of the finger."""
        boxes = list(self.drawing.objects)
        left, right = boxes[::2], boxes[1::2]
        assert [path.removesuffix("/left") for path in left] == [path.removesuffix("/right") for path in right]
        return [path.removesuffix("/left") for path in left]


MakeScene = Callable[..., Scene]


@pytest.fixture
def scene(bent: Callable[..., Array]) -> MakeScene:
    """Draws a bent finger with the sensors of `layout`; a reading or torque can be replaced."""

    def make(layout: SensorLayout, q: Array | None = None, failed: int | None = None, **other: Any) -> Scene:
        joints = layout.finger.segments
        angles = bent(joints) if q is None else q
        strain = layout.response.reading(extension_ratios(layout, angles))
        if failed is not None:
            strain[failed] = np.nan
        return Scene(layout, strain, other.pop("torque", np.zeros(joints)), **other)

    return make


def in_finger(points: Array) -> Array:
    """Points of the world in B."""
    return X_WB.inverse() @ points


def test_pieces_join_from_the_base_through_the_joints_to_the_tip(scene: MakeScene, layout: SensorLayout) -> None:
    seen = scene(layout)
    joints, tip = seen.estimate("joint_positions").reshape(-1, 2), seen.estimate("tip_pose")[:2]
    corners = np.concatenate([np.zeros((1, 2)), joints, tip[None]])
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    for i, (path, length) in enumerate(zip(seen.pieces(), lengths, strict=True)):
        ends = [in_finger(seen.drawing.in_world(path, [0, 0, side * length / 2])) for side in (-1, 1)]
        expected = np.insert(corners[i : i + 2], 1, 0.0, axis=1)
        np.testing.assert_allclose(ends, expected, atol=ROUNDING)
        for side in ("left", "right"):
            height = seen.drawing.objects[f"{path}/{side}"].height()
            assert length < height < 1.3 * length, "no gaps where the curve is bent"


def test_arcs_have_their_centre_and_end_where_the_curve_does(scene: MakeScene, layout: SensorLayout) -> None:
    seen = scene(layout, np.repeat([-0.1, 0.2], [3, 9]))
    ends = np.vstack([seen.arcs[1:, :2], seen.estimate("tip_pose")[:2]])
    for i, (arc, end) in enumerate(zip(seen.arcs, ends, strict=True)):
        path = f"{ARCS}/{NAME}/{i}/unit"
        on_circle = in_finger(seen.drawing.in_world(f"{path}/circle", seen.drawing.lines[f"{path}/circle"]))
        distances = np.linalg.norm(on_circle[::2] - arc[5:, None], axis=0)
        np.testing.assert_allclose(distances, 1 / abs(arc[3]), atol=ROUNDING)
        for radius, tip in (("begin", arc[:2]), ("end", end)):
            line = seen.drawing.lines[f"{path}/{radius}"]
            drawn = in_finger(seen.drawing.in_world(f"{path}/{radius}", line))
            np.testing.assert_allclose(drawn[::2].T, [arc[5:], tip], atol=ROUNDING)
