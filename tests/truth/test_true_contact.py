"""TrueContact against statics: blocks that rest on a pad, and a box between two balls."""

from collections.abc import Sequence

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    GeometryId,
    ProximityProperties,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, ContactResults, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.truth.true_contact import Patch, Touch, TrueContact, contact_width, touch

MODELS = ("hydroelastic_with_fallback", "point")
G = 9.81  # m/s^2
EDGE = 0.04  # m
STRAIGHT = RotationMatrix()
ASKEW = RollPitchYaw(0.4, -0.5, 1.1).ToRotationMatrix()  # nothing is parallel to an axis of the world


class World:
    """Soft and rigid shapes, described in a frame A that is turned in the world; weight pulls along -z of A."""

    def __init__(self, contact_model: str, R_WA: RotationMatrix = STRAIGHT, friction: float = 0.0):
        config = MultibodyPlantConfig(
            time_step=0.002,
            contact_model=contact_model,
            discrete_contact_approximation="lagged",
            use_sampled_output_ports=False,
        )
        self.builder, self.R_WA = DiagramBuilder(), R_WA
        self.plant, _ = AddMultibodyPlant(config, self.builder)
        self.plant.mutable_gravity_field().set_gravity_vector(R_WA @ [0, 0, -G])
        self.friction = CoulombFriction(friction, friction)

    def fixed(self, name: str, p_AB: Sequence[float], R_AB: RotationMatrix = STRAIGHT) -> RigidBody:
        body, place = self._body(name, 1.0, p_AB, R_AB)
        self.plant.WeldFrames(place, body.body_frame())
        return body

    def sliding(self, name: str, mass: float, p_AB: Sequence[float]) -> RigidBody:
        """A body that moves along z of A and does not turn."""
        body, place = self._body(name, mass, p_AB, STRAIGHT)
        self.plant.AddJoint(PrismaticJoint(name, place, body.body_frame(), [0, 0, 1], damping=1.0))
        return body

    def free(self, name: str, mass: float, p_AB: Sequence[float], R_AB: RotationMatrix) -> RigidBody:
        body, _ = self._body(name, mass, p_AB, R_AB)
        self.plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform(self.R_WA @ R_AB, self.R_WA @ p_AB))
        return body

    def _body(self, name, mass, p_AB, R_AB):
        inertia = SpatialInertia(mass, [0, 0, 0], UnitInertia.SolidCube(EDGE))
        X_WB = RigidTransform(self.R_WA, [0, 0, 0]) @ RigidTransform(R_AB, p_AB)
        place = self.plant.AddFrame(FixedOffsetFrame(f"{name}_place", self.plant.world_frame(), X_WB))
        return self.plant.AddRigidBody(name, inertia), place

    def shape(self, body: RigidBody, shape: Shape, is_soft: bool, p_BS: Sequence[float] = (0, 0, 0)) -> GeometryId:
        properties = ProximityProperties()
        AddContactMaterial(dissipation=5.0, point_stiffness=1e5, friction=self.friction, properties=properties)
        if is_soft:
            AddCompliantHydroelasticProperties(EDGE / 10, 1e6, properties)
        else:
            AddRigidHydroelasticProperties(EDGE, properties)
        name = f"{body.name()}_{p_BS}"
        return self.plant.RegisterCollisionGeometry(body, RigidTransform(p_BS), shape, name, properties)

    def settle(self, **fingers: set[GeometryId]) -> dict[str, Array]:
        """What is put out after a second, centres in A."""
        self.plant.Finalize()
        truth = self.builder.AddSystem(TrueContact(fingers))
        self.builder.Connect(self.plant.get_contact_results_output_port(), truth.get_input_port())
        simulator = Simulator(self.builder.Build())
        simulator.AdvanceTo(1.0)
        context = truth.GetMyContextFromRoot(simulator.get_context())
        self.context = self.plant.GetMyContextFromRoot(simulator.get_context())
        ports = [truth.get_output_port(i) for i in range(truth.num_output_ports())]
        found = {port.get_name(): port.Eval(context) for port in ports}
        return {name: self.turned(value) if name.endswith("center") else value for name, value in found.items()}

    def turned(self, p_W: Array) -> Array:
        """A place in the world, in A."""
        return self.R_WA.inverse() @ p_W

    def center(self, body: RigidBody) -> Array:
        """Where a body is now, in A."""
        return self.turned(body.EvalPoseInWorld(self.context).translation())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("tilt", [0.0, 0.3, -0.4])
def test_a_ball_on_a_smooth_slope(model, tilt):
    """Guided, and without friction, it is carried by the normal force alone: N cos(tilt) = m g."""
    world, turn = World(model, ASKEW), RotationMatrix.MakeYRotation(tilt)
    slope = world.shape(world.fixed("slope", [0, 0, 0], turn), Box(0.2, 0.2, 0.02), is_soft=False)
    ball = world.sliding("ball", 0.05, [0.01, 0.02, 0.04])
    world.shape(ball, Sphere(EDGE / 2), is_soft=True)
    found = world.settle(slope={slope}, other=set())
    assert found["slope.normal_force"] == pytest.approx([0.05 * G / np.cos(tilt)], rel=1e-3)
    # It touches where the perpendicular from its centre meets the slope.
    foot = turn.inverse() @ world.center(ball)
    foot[2] = 0.01
    np.testing.assert_allclose(turn.inverse() @ found["slope.contact_center"], foot, atol=5e-4)
    assert found["other.normal_force"] == 0
    assert np.isnan(found["other.contact_center"]).all()
    assert np.isnan(found["width"])


def block_on_a_rough_slope(model, tilt):
    """What presses on the slope, where that acts, and where it ought to; places in the frame of the slope."""
    world, turn = World(model, ASKEW, friction=0.9), RotationMatrix.MakeYRotation(tilt)
    slope = world.shape(world.fixed("slope", [0, 0, 0], turn), Box(0.2, 0.2, 0.02), is_soft=True)
    block = world.free("block", 0.05, turn @ [0, 0, (0.02 + EDGE) / 2 + 1e-5], turn)
    if model == "point":  # which knows one point a pair of shapes: the block gets feet
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            world.shape(block, Sphere(1e-3), is_soft=False, p_BS=[0.45 * EDGE * x, 0.45 * EDGE * y, -EDGE / 2 + 1e-3])
    else:
        world.shape(block, Box(EDGE, EDGE, EDGE), is_soft=False)
    found = world.settle(slope={slope}, other=set())
    below = [EDGE / 2 * np.tan(tilt), 0, -EDGE / 2]  # where the vertical through the middle meets the slope
    force, center = found["slope.normal_force"], found["slope.contact_center"]
    return force, turn.inverse() @ center, turn.inverse() @ world.center(block) + below


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("tilt", [0.0, 0.15, 0.3])
def test_friction_carries_its_part_of_a_block_on_a_slope(model, tilt):
    force, _, _ = block_on_a_rough_slope(model, tilt)
    assert force == pytest.approx([0.05 * G * np.cos(tilt)], rel=1e-3)


@pytest.mark.parametrize(
    ("model", "tilt"),
    [
        ("point", 0.15),
        (MODELS[0], 0.0),
        (MODELS[0], 0.15),
        (MODELS[0], 0.3),
    ],
)
def test_a_block_presses_on_a_slope_right_below_its_middle(model, tilt):
    _, center, expected = block_on_a_rough_slope(model, tilt)
    np.testing.assert_allclose(center, expected, atol=1e-4)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("offset", [0.0, 0.012])
def test_a_box_between_two_balls(model, offset):
    """One carries the box and the other, which lies on the box: the weights are known, and so is the width."""
    world, width = World(model, ASKEW), 0.03
    below = world.shape(world.fixed("below", [offset, 0, -0.02], STRAIGHT), Sphere(0.02), is_soft=True)
    box = world.sliding("box", 0.05, [0, 0, width / 2])
    world.shape(box, Box(0.06, 0.05, width), is_soft=False)
    above = world.shape(world.sliding("above", 0.08, [-offset, 0.01, width + 0.02]), Sphere(0.02), is_soft=True)
    found = world.settle(below={below}, above={above})
    assert found["above.normal_force"] == pytest.approx([0.08 * G], rel=1e-3)
    assert found["below.normal_force"] == pytest.approx([(0.05 + 0.08) * G], rel=1e-3)
    middle = world.center(box)
    np.testing.assert_allclose(found["below.contact_center"], [offset, 0, middle[2] - width / 2], atol=2e-4)
    np.testing.assert_allclose(found["above.contact_center"], [-offset, 0.01, middle[2] + width / 2], atol=2e-4)
    assert found["width"] == pytest.approx([width], abs=2e-4)


def test_shapes_of_a_finger_count_together():
    """A ball lies in the valley between two slopes: each carries m g / (2 cos), at both sides of the middle."""
    world, mass, angle = World("point", ASKEW), 0.06, 0.5
    shapes = set()
    for side in (-1, 1):
        slope = world.fixed(f"slope{side}", [0, 0, 0], RotationMatrix.MakeYRotation(-side * angle))
        shapes.add(world.shape(slope, Box(0.1, 0.2, 0.02), is_soft=True, p_BS=[side * 0.05, 0, 0]))
    ball = world.sliding("ball", mass, [0, 0, 0.05])
    world.shape(ball, Sphere(EDGE / 2), is_soft=False)
    found = world.settle(valley=shapes, other=set())
    assert found["valley.normal_force"] == pytest.approx([mass * G / np.cos(angle)], rel=1e-3)
    center = found["valley.contact_center"] - world.center(ball)
    np.testing.assert_allclose(center, [0, 0, -EDGE / 2 * np.cos(angle)], atol=2e-4)


ONE, TWO, OTHER, THING = (GeometryId.get_new_id() for _ in range(4))
X, Y = np.eye(3)[:2]


def patch(first, second, center, normal, force):
    return Patch(frozenset((first, second)), np.array(center, dtype=float), normal, force)


def test_only_what_is_outside_presses_on_a_finger():
    found = [patch(ONE, TWO, [9, 9, 9], X, 50.0), patch(TWO, THING, [1, 2, 3], Y, 2.0), patch(OTHER, THING, X, X, 7.0)]
    force, center, normal = touch({ONE, TWO}, found)
    assert force == 2
    np.testing.assert_array_equal(center, [1, 2, 3])
    np.testing.assert_array_equal(normal, Y)


def test_patches_count_by_their_force():
    found = [patch(THING, ONE, [0, 0, 0], X, 1.0), patch(TWO, OTHER, [4, 0, 8], Y, 3.0)]
    force, center, normal = touch({ONE, TWO}, found)
    assert force == 4
    np.testing.assert_array_equal(center, [3, 0, 6])
    np.testing.assert_array_equal(normal, Y)


@pytest.mark.parametrize("found", [[], [patch(ONE, THING, X, X, 0.0)], [patch(OTHER, THING, X, X, 1.0)]])
def test_nothing_presses(found):
    force, center, normal = touch({ONE, TWO}, found)
    assert force == 0
    assert np.isnan([center, normal]).all()


def test_fingers_that_press_on_each_other_are_both_touched():
    found = [patch(ONE, OTHER, X, X, 2.0)]
    assert touch({ONE}, found).force == touch({OTHER}, found).force == 2


def on_circle(count, radius, heights):
    """What fingers around a cylinder touch; normals may point either way."""
    out = [RollPitchYaw(0, 0, angle).ToRotationMatrix() @ X for angle in 2 * np.pi * np.arange(count) / count]
    centers = [radius * x + [1, 2, 3 + height] for x, height in zip(out, heights, strict=True)]
    return [Touch(1.0, center, (-1) ** i * x) for i, (center, x) in enumerate(zip(centers, out, strict=True))]


@pytest.mark.parametrize("count", [2, 3, 4])
def test_width_of_a_cylinder_is_its_diameter(count):
    """However high each finger touches it."""
    assert contact_width(on_circle(count, 0.03, np.zeros(count))) == pytest.approx(0.06, rel=1e-12)
    assert contact_width(on_circle(count, 0.03, 0.01 * np.arange(count))) == pytest.approx(0.06, rel=1e-12)


def test_width_of_a_box_is_the_distance_of_its_faces():
    """Wherever on them it is touched, and whichever way the normals point."""
    faces = [Touch(1.0, np.array([0.02, 0.01, 0.05]), X), Touch(2.0, np.array([-0.03, -0.01, 0.02]), X)]
    assert contact_width(faces) == pytest.approx(0.05, rel=1e-12)


def test_there_is_no_width_unless_two_fingers_or_more_all_touch():
    untouched = touch({ONE}, [])
    for touches in ([], on_circle(1, 0.03, [0]), [*on_circle(2, 0.03, [0, 0]), untouched]):
        assert np.isnan(contact_width(touches))


def test_ports():
    truth = TrueContact({"left": {ONE}, "right": {TWO}})
    assert (truth.num_input_ports(), truth.get_input_port().get_name()) == (1, "contact_results")
    ports = [truth.get_output_port(i) for i in range(truth.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in ports] == [
        ("left.normal_force", 1),
        ("left.contact_center", 3),
        ("right.normal_force", 1),
        ("right.contact_center", 3),
        ("width", 1),
    ]


def test_without_contact_there_is_no_force_and_no_place():
    truth = TrueContact({"left": {ONE}, "right": {TWO}})
    context = truth.CreateDefaultContext()
    truth.get_input_port().FixValue(context, ContactResults())
    values = {name: truth.GetOutputPort(name).Eval(context) for name in ("left.normal_force", "width")}
    assert values["left.normal_force"] == 0
    assert np.isnan(values["width"])
