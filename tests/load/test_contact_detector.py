"""ContactDetector: thresholds on a torque that is given, no false alarm in motion, and no late one."""

import numpy as np
import pytest
from finger_plants import free_bending
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, MatrixGain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.arc_shapes import ArcShape
from soft_gripper.estimators.plane import bending_plane
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.load.contact_detector import THRESHOLD, ContactDetector
from soft_gripper.load.force_estimator import ForceEstimator
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.base_pose import BasePoseSensor
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.signals import signal_of

GRAVITY = np.array([0.0, 0.0, -9.81])
PERIOD = 0.01  # s
FINGERS = ("left_finger", "right_finger")
PORTS = ("contact", "contact_residual", "contact_time")
NONE, CERTAIN = np.zeros(4), np.zeros(4)  # N m, no torque, no tolerance


class Detector:
    """A ContactDetector of four joints, two of them at the base, whose samples are given by hand, one a period."""

    def __init__(self, block=None):
        self.block = block or ContactDetector(4, 2, PERIOD)
        self.context = self.block.CreateDefaultContext()
        self.samples = 0

    def sample(self, torque, tolerance=CERTAIN):
        """Contact, residual and time of contact at the next sample."""
        self.context.SetTime(self.samples * PERIOD)
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        self.samples += 1
        self.block.GetInputPort("external_torque").FixValue(self.context, torque)
        self.block.GetInputPort("torque_tolerance").FixValue(self.context, tolerance)
        return [float(self.block.GetOutputPort(name).Eval(self.context)[0]) for name in PORTS]


def at_base(size):
    """Torques whose mean at the base is `size` times the threshold."""
    return THRESHOLD * np.array([1.5 * size, 0.5 * size, 70.0, -90.0])


def test_ports():
    block = ContactDetector(12, 3, PERIOD)
    inputs = [(block.get_input_port(i).get_name(), block.get_input_port(i).size()) for i in range(2)]
    assert inputs == [("external_torque", 12), ("torque_tolerance", 12)]
    outputs = [block.get_output_port(i) for i in range(3)]
    assert [(port.get_name(), port.size()) for port in outputs] == [(name, 1) for name in PORTS]
    assert [signal_of(port).unit for port in outputs] == ["1", "N m", "s"]


def test_residual_is_the_mean_torque_at_the_base(bent):
    detector = Detector()
    for torque in bent(10, 4):
        assert detector.sample(torque)[1] == pytest.approx((torque[0] + torque[1]) / 2, rel=1e-14)


def test_contact_begins_beyond_the_threshold_and_ends_below_half_of_it():
    detector = Detector()
    sizes = np.interp(np.arange(1600), [0, 200, 400, 800, 1000, 1600], [0, 0.9, 0.6, 1.4, 0.6, -1.4])
    contact, residual, since = np.array([detector.sample(at_base(size)) for size in sizes]).T
    changes = np.flatnonzero(np.diff(contact)) + 1
    size = np.abs(residual) / THRESHOLD
    np.testing.assert_array_equal(contact[changes], [1, 0, 1])
    np.testing.assert_allclose(size[changes], [1.0, 0.5, 1.0], atol=0.01)
    np.testing.assert_array_equal(size[changes] > size[changes - 1], [True, False, True])
    begun = changes[[0, 2]]
    expected = np.select([np.arange(1600) >= begin for begin in begun[::-1]], begun[::-1] * PERIOD, np.nan)
    np.testing.assert_allclose(since, expected)


def test_tolerance_counts_against_every_change():
    """Its mean at the base, whichever way the torque points."""
    detector, tolerance = Detector(), at_base(0.3)
    script = ((1.25, 0.0), (-1.25, 0.0), (-1.35, 1.0), (0.25, 1.0), (0.15, 0.0))
    for size, contact in script:
        assert detector.sample(at_base(size), tolerance)[0] == contact


@pytest.mark.parametrize("unknown", [(np.nan, np.nan), (-np.inf, np.inf), (np.inf, np.nan)], ids=str)
@pytest.mark.parametrize(("size", "contact"), [(0.0, 0.0), (0.7, 1.0), (-0.7, 1.0)])
def test_contact_is_held_while_the_torque_is_not_finite(size, contact, unknown):
    """As a ForceEstimator puts torque and tolerance out of readings that are not."""
    detector = Detector()
    detector.sample(at_base(2.0 * contact))
    before = detector.sample(at_base(size))
    assert before[0] == contact
    with np.errstate(invalid="ignore"):
        held, residual, since = detector.sample(*(np.full(4, value) for value in unknown))
    assert held == contact
    assert not np.isfinite(residual)
    np.testing.assert_equal(since, before[2])
    np.testing.assert_array_equal(detector.sample(at_base(size)), before)


def test_what_is_remembered_lies_in_the_context(bent):
    block = ContactDetector(4, 2, PERIOD)
    one, other, reference = Detector(block), Detector(block), Detector()
    for torque in 0.01 * bent(8, 4):
        other.sample(-torque)
        np.testing.assert_array_equal(one.sample(torque), reference.sample(torque))


def first(flags):
    """Index of the first flag that is set."""
    assert flags.any()
    return int(np.argmax(flags))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box_grasp", "irregular_grasp"])
@pytest.mark.parametrize("pressure", [50e3, 120e3])
def test_the_touch_of_an_object_is_detected_within_50_ms_and_not_before(name, pressure):
    short = ("pressure.settle=0.49", "pressure.hold_samples=1", f"pressure.steps.all=[0, {pressure}]")
    recording = simulate(load_scenario(name, [*short, f"estimator.contact_threshold={THRESHOLD}"]))
    for finger in FINGERS:
        contact, since = (recording[f"{finger}.{signal}"].values.squeeze() for signal in ("contact", "contact_time"))
        touched, detected = first(recording[f"{finger}.true_external_torque"].values.any(axis=1)), first(contact > 0)
        assert 0 <= (detected - touched) * PERIOD <= 0.05
        assert since[-1] == pytest.approx((detected - 1) * PERIOD)  # a recording shows the sample before
        assert contact[detected:].all()


@pytest.mark.parametrize(("time_step", "threshold"), [(0.01, THRESHOLD), (0.0025, 1e-3)])
def test_in_free_air_no_step_of_the_pressure_is_taken_for_contact(time_step, threshold):
    overrides = (f"plant_config.time_step={time_step}", f"estimator.contact_threshold={threshold}")
    recording = simulate(free_bending([-50e3, 210e3, 0.0, 100e3, -50e3], 0.4, *overrides))
    for finger in FINGERS:
        names = ("external_torque", "contact_residual", "contact", "contact_time", "true_external_torque")
        # A recording shows the sample before: the first is in its second row.
        torque, residual, contact, since, truth = (recording[f"{finger}.{name}"].values[1:].squeeze() for name in names)
        assert np.isnan(residual[:4]).all()
        np.testing.assert_allclose(residual[4:], torque[4:, :3].mean(axis=1), atol=1e-15)
        assert np.abs(residual[4:]).max() > threshold  # which the tolerance has to cover
        assert not contact.any()
        assert not truth.any()
        assert np.isnan(since).all()


# Where the carriage moves along or turns about, the time in which it speeds up and slows down, and how fast.
AXES = (
    ("x", PrismaticJoint, [1, 0, 0], 0.10, 8.0),  # s, m/s^2
    ("z", PrismaticJoint, [0, 0, 1], 0.13, 8.0),
    ("roll", RevoluteJoint, [1, 0, 0], 0.09, 30.0),  # s, rad/s^2
    ("pitch", RevoluteJoint, [0, 1, 0], 0.11, 30.0),
)
TIMES = np.arange(0.0, 2.005, 0.01)  # s


def add_carriage(plant):
    """A heavy carriage that holds to its commands; returns its model and the frame that it carries."""
    model, carried = plant.AddModelInstance("carriage"), plant.world_frame()
    for name, kind, axis, *_ in AXES:
        body = plant.AddRigidBody(name, model, SpatialInertia.SolidCubeWithDensity(100.0, 1.0))
        joint = plant.AddJoint(kind(name, carried, body.body_frame(), axis))
        plant.AddJointActuator(name, joint).set_controller_gains(PdControllerGains(p=1e8, d=1e6))
        carried = body.body_frame()
    return model, carried


def shaken():
    """Motion of the carriage, to and fro at full acceleration along and about all of its axes."""
    turning_points = ((0.0, 1.0, 2.0, 3.0, 4.0), (0.0, 1.0, 0.0, -1.0, 0.0))
    speeds = np.array([rate * beat * np.interp(TIMES / beat % 4, *turning_points) for *_, beat, rate in AXES])
    steps = (speeds[:, 1:] + speeds[:, :-1]) / 2 * np.diff(TIMES)
    return PiecewisePolynomial.CubicHermite(TIMES, np.insert(steps.cumsum(axis=1), 0, 0.0, axis=1), speeds)


def run_carried_finger(sections, time_step, torque, since):
    """Signals of a finger on the carriage, by name: X_WB, estimated_joint_angles, contact; each (T, ...).

    From `since` on, s, `torque` (N,) N m acts on its joints.
    """
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=time_step, use_sampled_output_ports=False), builder)
    carriage, frame = add_carriage(plant)
    expanded = expand_urdf(DIRECTORY / "grippers" / "finger.urdf")
    (model,) = Parser(plant).AddModelsFromString(expanded.text, "urdf")
    plant.WeldFrames(frame, plant.GetFrameByName("mount"), RigidTransform([0.1, 0.0, 0.1]))
    plant.Finalize()
    carried = PlantFinger(expanded.fingers[0], plant, model)
    layout = SensorLayout(carried.finger, sections)

    def add(system, *inputs):
        builder.AddSystem(system)
        for i, port in enumerate(inputs):
            builder.Connect(port, system.get_input_port(i))
        return system.get_output_port(0)

    motion = add(TrajectorySource(shaken(), output_derivative_order=1))
    builder.Connect(motion, plant.get_desired_state_input_port(carriage))
    forces = np.zeros((plant.num_velocities(), 2))
    forces[[joint.velocity_start() for joint in carried.joints], 1] = torque
    force = add(TrajectorySource(PiecewisePolynomial.ZeroOrderHold([0.0, since, 9.0], forces[:, [0, 1, 1]])))
    builder.Connect(force, plant.get_applied_generalized_force_input_port())

    joint_angles = add(MatrixGain(carried.position_selector()), plant.get_state_output_port())
    strain = add(SensorBlock(layout, PERIOD), joint_angles).get_system().GetOutputPort("strain")
    X_WB = add(BasePoseSensor(carried.base.index(), PERIOD), plant.get_body_poses_output_port())
    known = add(ConstantVectorSource(np.zeros(12))), X_WB  # driving torque and pose of the base
    q = add(ShapeEstimator(ArcShape(layout), layout, GRAVITY), strain, *known)
    forces = add(ForceEstimator(carried.finger, GRAVITY, PERIOD), q, *known).get_system()
    balance = (forces.GetOutputPort(name) for name in ("external_torque", "torque_tolerance"))
    contact = add(ContactDetector(12, int(layout.joints_per_section[0]), PERIOD), *balance)
    logs = {port.get_name(): LogVectorOutput(port, builder, PERIOD) for port in (X_WB, q, contact)}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(TIMES[-1])
    return {name: log.FindLog(simulator.get_context()).data().T for name, log in logs.items()}


@pytest.mark.parametrize("time_step", [0.01, 0.005])
@pytest.mark.parametrize("sections", [2, 4])
def test_a_touch_is_detected_while_the_base_is_shaken_and_nothing_before(shipped_finger, sections, time_step):
    """A force of 0.15 N at the tip that holds the finger open."""
    torque = -0.15 * (shipped_finger.length - shipped_finger.joint_arc_lengths)
    signals = run_carried_finger(sections, time_step, torque, since=1.5)
    detected = first(signals["contact"][:, 0] > 0) - 1  # a log shows the sample before
    assert 1.5 <= detected * PERIOD <= 1.55
    q = signals["estimated_joint_angles"]
    gravity = np.array([[bending_plane(X_WB).planar(GRAVITY)] for X_WB in signals["X_WB"]])
    static = shipped_finger.elastic_torque(q) - gravity_torque(shipped_finger, q, gravity)
    assert np.abs(static[10:150, 0]).max() > 10 * THRESHOLD  # what shaking is taken for if inertia is not counted
