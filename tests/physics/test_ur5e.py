"""The default arm, as bare Drake loads it, against the tables that its maker publishes.

DH frame 0 is base_link turned by 180 degrees about z; frame i is fixed to the i-th moving link.
"""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from pydrake.geometry import Cylinder, Role
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.models import DIRECTORY

FILE = DIRECTORY / "arms/ur5e.urdf"
LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link")
JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
DH_D = (0.1625, 0, 0, 0.1333, 0.0997, 0.0996)  # m
DH_A = (0, -0.425, -0.3922, 0, 0, 0)  # m
DH_ALPHA = np.radians([90, 0, 0, 90, -90, 0])
MASSES = (3.761, 8.058, 2.846, 1.37, 1.3, 0.365)  # kg
CENTERS = (  # of mass, in the DH frame of the link, m
    (0, -0.02561, 0.00193),
    (0.2125, 0, 0.11336),
    (0.15, 0, 0.0265),
    (0, -0.0018, 0.01634),
    (0, 0.0018, 0.01634),
    (0, 0, -0.001159),
)
INERTIAS = (  # xx, yy, zz, xy, xz, yz about the centre of mass, in the axes of the DH frame, kg m^2
    (0.0070021, 0.00648091, 0.00657286, 0.00000073, -0.00001053, 0.00049994),
    (0.01505885, 0.33388086, 0.33247207, -0.000054, 0.00000563, -0.00000181),
    (0.00399632, 0.07879254, 0.0784851, -0.00001365, 0.00137272, -0.0000066),
    (0.00165491, 0.00135962, 0.00126279, -0.00000282, -0.00000438, 0.00010157),
    (0.00135617, 0.00127827, 0.00096614, -0.00000274, 0.00000444, -0.00005048),
    (0.00018694, 0.00018908, 0.00025756, 0.00000006, -0.00000017, -0.00000092),
)
EFFORTS = (150, 150, 150, 28, 28, 28)  # N m
HOME = np.radians([0, -90, 90, -90, -90, 0])
STRETCHED = np.zeros(6)
FOLDED = np.radians([0, -90, 179, 0, 0, 0])
POSTURES = (HOME, STRETCHED, *np.random.default_rng(1).uniform(-np.pi, np.pi, (5, 6)))


class Arm:
    """The arm alone in a scene, its base welded to the world."""

    def __init__(self, text: str):
        builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        Parser(self.plant).AddModelsFromString(text, "urdf")
        self.plant.WeldFrames(self.plant.world_frame(), self.plant.GetFrameByName("base_link"))
        self.plant.Finalize()
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()
        self.context = self.plant.GetMyMutableContextFromRoot(self._root)

    def pose(self, q, frame) -> RigidTransform:
        self.plant.SetPositions(self.context, q)
        return self.plant.GetFrameByName(frame).CalcPoseInWorld(self.context)

    def query(self, q):
        self.plant.SetPositions(self.context, q)
        scene_context = self.scene_graph.GetMyContextFromRoot(self._root)
        return self.scene_graph.get_query_output_port().Eval(scene_context)

    def shapes(self, link, role):
        """Each shape of a link, and its pose in the link."""
        frame = self.plant.GetBodyFrameIdOrThrow(self.plant.GetBodyByName(link).index())
        inspector = self.scene_graph.model_inspector()
        return [(inspector.GetShape(g), inspector.GetPoseInFrame(g)) for g in inspector.GetGeometries(frame, role)]


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(FILE.read_text())


@pytest.fixture(scope="module")
def unfiltered_arm() -> Arm:
    """The arm without its collision filter."""
    robot = ET.parse(FILE).getroot()
    robot.remove(robot.find("{http://drake.mit.edu}collision_filter_group"))
    return Arm(ET.tostring(robot, encoding="unicode"))


def dh_frames(q):
    """Poses in the world of the DH frames 0 to 6."""
    poses = [RigidTransform(RotationMatrix.MakeZRotation(np.pi), [0, 0, 0])]
    for angle, d, a, alpha in zip(q, DH_D, DH_A, DH_ALPHA, strict=True):
        along_z = RigidTransform(RotationMatrix.MakeZRotation(angle), [0, 0, d])
        along_x = RigidTransform(RotationMatrix.MakeXRotation(alpha), [a, 0, 0])
        poses.append(poses[-1] @ along_z @ along_x)
    return poses


@pytest.mark.parametrize("q", POSTURES)
def test_flange_is_the_end_of_the_dh_chain(arm, q):
    tool, expected = arm.pose(q, "tool0"), dh_frames(q)[-1]
    np.testing.assert_allclose(tool.translation(), expected.translation(), rtol=0, atol=1e-9)
    assert (tool.rotation().inverse() @ expected.rotation()).ToAngleAxis().angle() < 1e-9


@pytest.mark.parametrize("q", POSTURES)
def test_each_joint_turns_about_the_z_axis_of_the_dh_frame_before_it(arm, q):
    for link, frame in zip(LINKS, dh_frames(q), strict=False):
        np.testing.assert_allclose(arm.pose(q, link).rotation().col(2), frame.rotation().col(2), atol=1e-9)


def test_masses(arm):
    masses = [arm.plant.GetBodyByName(link).get_mass(arm.context) for link in LINKS]
    assert masses == pytest.approx(MASSES, rel=1e-12)
    base, tool = (arm.plant.GetBodyByName(name).get_mass(arm.context) for name in ("base_link", "tool0"))
    assert (base, tool) == (4, 0)
    assert arm.plant.CalcTotalMass(arm.context) == pytest.approx(21.7, rel=1e-12)


@pytest.mark.parametrize("q", POSTURES[:3])
def test_centers_of_mass_and_inertias_in_dh_frames(arm, q):
    for i, (link, X_WD) in enumerate(zip(LINKS, dh_frames(q)[1:], strict=True)):
        X_DL = X_WD.inverse() @ arm.pose(q, link)
        body = arm.plant.GetBodyByName(link)
        spatial = body.CalcSpatialInertiaInBodyFrame(arm.context)
        np.testing.assert_allclose(X_DL @ spatial.get_com(), CENTERS[i], atol=1e-9)
        central = spatial.Shift(spatial.get_com()).CalcRotationalInertia().ReExpress(X_DL.rotation())
        found = [*central.get_moments(), *central.get_products()]
        np.testing.assert_allclose(found, INERTIAS[i], atol=1e-12)


def test_limits_and_actuators(arm):
    plant = arm.plant
    assert plant.num_positions() == plant.num_actuators() == 6
    for name, effort in zip(JOINTS, EFFORTS, strict=True):
        joint, actuator = plant.GetJointByName(name), plant.GetJointActuatorByName(name)
        reach = np.pi if name == "elbow_joint" else 2 * np.pi
        assert (joint.position_lower_limits(), joint.position_upper_limits()) == pytest.approx([-reach, reach])
        assert (joint.velocity_lower_limits(), joint.velocity_upper_limits()) == pytest.approx([-np.pi, np.pi])
        assert actuator.joint().index() == joint.index()
        assert actuator.effort_limit() == effort
        assert joint.default_damping() == 0


@pytest.mark.parametrize("q", POSTURES)
def test_motors_can_hold_the_arm(arm, q):
    """The torque of gravity about a joint is that of the masses beyond it, and less than the motor's."""
    frames, expected = dh_frames(q), np.zeros(6)
    weights = np.outer(MASSES, [0, 0, -9.81])
    centers = np.array([X_WD @ p for X_WD, p in zip(frames[1:], CENTERS, strict=True)])
    for i, frame in enumerate(frames[:-1]):
        moment = np.cross(centers[i:] - frame.translation(), weights[i:]).sum(axis=0)
        expected[i] = moment @ frame.rotation().col(2)
    arm.plant.SetPositions(arm.context, q)
    np.testing.assert_allclose(arm.plant.CalcGravityGeneralizedForces(arm.context), expected, atol=1e-9)
    assert np.all(np.abs(expected) < EFFORTS)


def test_arm_does_not_collide_with_itself(arm, unfiltered_arm):
    assert unfiltered_arm.query(FOLDED).HasCollisions()
    assert not arm.query(FOLDED).HasCollisions()


def outline(shape: Cylinder, X_LG: RigidTransform):
    """Points on the two rims of a cylinder, (M, 3) m in the link."""
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    x, y, z = shape.radius() * np.cos(angle), shape.radius() * np.sin(angle), np.full(16, shape.length() / 2)
    return (X_LG @ np.block([[x, x], [y, y], [-z, z]])).T


@pytest.mark.parametrize("link", ["base_link", *LINKS])
def test_collision_shapes_enclose_what_is_seen(arm, link):
    collisions = arm.shapes(link, Role.kProximity)
    assert 1 <= len(collisions) <= 3
    for shape, X_LG in arm.shapes(link, Role.kIllustration):
        p_L = outline(shape, X_LG)
        outside = np.full(len(p_L), np.inf)
        for around, X_LC in collisions:
            p_C = (X_LC.inverse() @ p_L.T).T
            radial = np.hypot(p_C[:, 0], p_C[:, 1]) - around.radius()
            outside = np.minimum(outside, np.maximum(radial, np.abs(p_C[:, 2]) - around.length() / 2))
        assert outside.max() < 1e-9


def test_arm_stands_on_its_base_and_ends_at_its_flange(arm):
    base, last = (
        np.concatenate([outline(*each) for each in arm.shapes(link, Role.kProximity)])
        for link in ("base_link", "wrist_3_link")
    )
    assert base[:, 2].min() == pytest.approx(0, abs=1e-12)
    assert last[:, 2].max() == pytest.approx(0, abs=1e-12)
