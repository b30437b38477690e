"""TrueContact against statics: blocks that rest on a pad, and a box between two balls."""

from collections.abc import Sequence

import numpy as np
import pytest
from pydrake.common.value import AbstractValue, Value
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
from pydrake.multibody.tree import BodyIndex, FixedOffsetFrame, PrismaticJoint, RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.signals import signal_of
from soft_gripper.truth.contact import TouchedLinks, TrueContact

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
        self.body_of: dict[int, RigidBody] = {}
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

    def shape(self, body: RigidBody, shape: Shape, is_soft: bool, p_BS: Sequence[float] = (0, 0, 0)) -> int:
        properties = ProximityProperties()
        AddContactMaterial(dissipation=5.0, point_stiffness=1e5, friction=self.friction, properties=properties)
        if is_soft:
            AddCompliantHydroelasticProperties(EDGE / 10, 1e6, properties)
        else:
            AddRigidHydroelasticProperties(EDGE, properties)
        name = f"{body.name()}_{p_BS}"
        found = self.plant.RegisterCollisionGeometry(body, RigidTransform(p_BS), shape, name, properties).get_value()
        self.body_of[found] = body
        return found

    def settle(self, **fingers: set[int]) -> dict[str, Array]:
        """What is put out after a second, centres in A; every shape of a finger counts as a link that begins at 0."""
        self.plant.Finalize()
        links = {
            name: TouchedLinks(
                [self.body_of[shape].index() for shape in shapes], [[s] for s in shapes], 0.0 * np.arange(len(shapes))
            )
            for name, shapes in fingers.items()
        }
        truth = self.builder.AddSystem(TrueContact(links))
        self.builder.Connect(self.plant.get_contact_results_output_port(), truth.GetInputPort("contact_results"))
        self.builder.Connect(self.plant.get_body_poses_output_port(), truth.GetInputPort("body_poses"))
        simulator = Simulator(self.builder.Build())
        simulator.AdvanceTo(1.0)
        context = truth.GetMyContextFromRoot(simulator.get_context())
        self.context = self.plant.GetMyContextFromRoot(simulator.get_context())
        ports = vector_outputs(truth).values()
        found = {port.get_name(): port.Eval(context) for port in ports}
        return {name: self.turned(value) if name.endswith("center") else value for name, value in found.items()}

    def turned(self, p_W: Array) -> Array:
        """A place in the world, in A."""
        return self.R_WA.inverse() @ p_W

    def center(self, body: RigidBody) -> Array:
        """Where a body is now, in A."""
        return self.turned(body.EvalPoseInWorld(self.context).translation())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("tilt", [0.15, 0.3])
def test_a_block_presses_on_a_rough_slope_right_below_its_middle(model, tilt):
    """Friction carries its part."""
    world, turn = World(model, ASKEW, friction=0.9), RotationMatrix.MakeYRotation(tilt)
    slope = world.shape(world.fixed("slope", [0, 0, 0], turn), Box(0.2, 0.2, 0.02), is_soft=True)
    block = world.free("block", 0.05, turn @ [0, 0, (0.02 + EDGE) / 2 + 1e-5], turn)
    if model == "point":  # which knows one point a pair of shapes: the block gets feet
        for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            world.shape(block, Sphere(1e-3), is_soft=False, p_BS=[0.45 * EDGE * x, 0.45 * EDGE * y, -EDGE / 2 + 1e-3])
    else:
        world.shape(block, Box(EDGE, EDGE, EDGE), is_soft=False)
    found = world.settle(slope={slope}, other=set())
    assert found["slope.true_contact_total"] == pytest.approx([0.05 * G], rel=1e-3)  # with friction, all its weight
    # The weight pulls toward +x of the slope where that leads down: from the side that counts as outer.
    assert found["slope.true_contact_force"] == pytest.approx([-0.05 * G * np.sin(tilt)], abs=1e-3 * 0.05 * G)
    assert found["slope.normal_force"] == pytest.approx([0.05 * G * np.cos(tilt)], rel=1e-3)
    below = [EDGE / 2 * np.tan(tilt), 0, -EDGE / 2]  # where the vertical through the middle meets the slope
    center, expected = turn.inverse() @ found["slope.contact_center"], turn.inverse() @ world.center(block) + below
    np.testing.assert_allclose(center, expected, atol=1e-4 if tilt < 0.2 or model != "point" else 1e-3)


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


LINK = TouchedLinks([BodyIndex(0)], [[GeometryId.get_new_id().get_value()]], [0.0])


def test_without_contact_there_is_no_force_and_no_place():
    truth = TrueContact({"left": LINK, "right": LINK})
    context = truth.CreateDefaultContext()
    truth.GetInputPort("contact_results").FixValue(context, Value(ContactResults()))
    truth.GetInputPort("body_poses").FixValue(context, AbstractValue.Make([RigidTransform()]))
    for port in vector_outputs(truth).values():
        is_force = signal_of(port).unit == "N"
        np.testing.assert_array_equal(port.Eval(context), 0 if is_force else np.nan)


def test_contacts_are_known_at_multiples_of_an_interval_alone():
    """From the beginning of the run, however rounded the time is."""
    truth = TrueContact({"left": LINK, "right": LINK}, interval=0.1)
    context = truth.CreateDefaultContext()
    truth.GetInputPort("contact_results").FixValue(context, Value(ContactResults()))
    truth.GetInputPort("body_poses").FixValue(context, AbstractValue.Make([RigidTransform()]))
    for time in (0.0, 0.04, 0.05, 0.1, 0.15, 0.3, 3 * 0.1, 0.31, 0.395, 0.7, 12.3, 12.35):
        context.SetTime(time)
        is_known = min(time % 0.1, -time % 0.1) < 1e-9
        force = truth.GetOutputPort("left.normal_force").Eval(context)
        np.testing.assert_array_equal(force, 0.0 if is_known else np.nan, str(time))
