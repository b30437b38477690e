"""ContactDetector: the maths of `contact_residual` behind ports; no false alarm in motion, and none late."""

import numpy as np
import pytest
from finger_plants import free_bending
from numpy.lib.stride_tricks import sliding_window_view
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, MatrixGain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.base_pose_sensor import BasePoseSensor
from soft_gripper.contact_detector import THRESHOLD, ContactDetector
from soft_gripper.contact_residual import BaseSection, Motion, contact_residual
from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import run_station, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.finger_links import joint_name, link_name
from soft_gripper.force_estimator import ForceEstimator
from soft_gripper.models import DIRECTORY
from soft_gripper.sensor_layout import SensorLayout
from soft_gripper.strain_sensor import StrainSensor
from soft_gripper.urdf import expand_urdf

GRAVITY = np.array([0.0, 0.0, -9.81])
PERIOD = 0.01  # s
UPRIGHT = RigidTransform()
FINGERS = ("left_finger", "right_finger")


class Detector:
    """A ContactDetector whose samples are given by hand, one a period."""

    def __init__(self, layout, block=None):
        self.block = block or ContactDetector(layout, GRAVITY, PERIOD)
        self.context = self.block.CreateDefaultContext()
        self.samples = 0

    def feel(self, theta, pressure=0.0, X_WB=UPRIGHT):
        """Contact, residual and time of contact at the next sample."""
        if self.samples:
            self.context.SetTime(self.samples * PERIOD)
            self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        self.samples += 1
        for name, value in (("theta", theta), ("pressure", [pressure]), ("X_WB", Value(X_WB))):
            self.block.GetInputPort(name).FixValue(self.context, value)
        ports = ("contact", "contact_residual", "contact_time")
        return [float(self.block.GetOutputPort(name).Eval(self.context)[0]) for name in ports]


def pressed(layout, torque):
    """Bend of the sections, rad, of a straight finger that hangs on `torque` N m at every joint."""
    return np.add.reduceat(torque / layout.finger.stiffness, layout.section_ends[:-1])


def test_ports(layout):
    block = ContactDetector(layout, GRAVITY, PERIOD)
    assert block.GetInputPort("theta").size() == layout.sections
    assert block.GetInputPort("pressure").size() == 1
    assert block.num_input_ports() == 3
    sizes = [(block.get_output_port(i).get_name(), block.get_output_port(i).size()) for i in range(3)]
    assert sizes == [("contact", 1), ("contact_residual", 1), ("contact_time", 1)]


def test_residual_is_the_pure_function_of_the_last_five_samples(layout, bent):
    theta, pressure, angles = 0.1 * bent(12, layout.sections), 1e5 * bent(12), bent(12, 3)
    poses = [RigidTransform(RollPitchYaw(angle), 0.01 * angle) for angle in angles]
    detector = Detector(layout)
    felt = np.array([detector.feel(*sample)[1] for sample in zip(theta, pressure, poses, strict=True)])
    X_WB = np.array([pose.GetAsMatrix34() for pose in poses])
    assert np.isnan(felt[:4]).all()
    for last in range(4, 12):
        five = slice(last - 4, last + 1)
        expected = contact_residual(
            BaseSection(layout), Motion(theta[five], pressure[five], X_WB[five]), GRAVITY, PERIOD
        )
        assert felt[last] == pytest.approx(expected.torque, rel=1e-9)


def test_contact_begins_beyond_the_threshold_and_ends_below_half_of_it(shipped_finger):
    detector, layout = Detector(SensorLayout(shipped_finger, 4)), SensorLayout(shipped_finger, 4)
    sizes = np.interp(np.arange(1600), [0, 200, 400, 800, 1000, 1600], [0, 0.9, 0.6, 1.4, 0.6, -1.4])
    told = [detector.feel(pressed(layout, np.full(12, size * THRESHOLD))) for size in sizes]
    contact, residual, since = np.array(told).T
    changes = np.flatnonzero(np.diff(contact)) + 1
    size = np.abs(residual) / THRESHOLD
    np.testing.assert_array_equal(contact[changes], [1, 0, 1])
    np.testing.assert_allclose(size[changes], [1.0, 0.5, 1.0], atol=0.01)
    np.testing.assert_array_equal(size[changes] > size[changes - 1], [True, False, True])
    begun = changes[[0, 2]]
    expected = np.select([np.arange(1600) >= begin for begin in begun[::-1]], begun[::-1] * PERIOD, np.nan)
    np.testing.assert_allclose(since, expected)


@pytest.mark.parametrize("signal", ["theta", "pressure"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_bad_reading_lasts_no_longer_than_five_samples_and_contact_is_held(shipped_finger, signal, bad):
    layout = SensorLayout(shipped_finger, 4)
    for size, contact in ((0.0, 0.0), (2.0, 1.0)):
        detector, theta = Detector(layout), pressed(layout, np.full(12, size * THRESHOLD))
        before = [detector.feel(theta) for _ in range(10)][-1]
        assert before[0] == contact
        reading = (np.full(4, bad), 0.0) if signal == "theta" else (theta, bad)
        with np.errstate(invalid="ignore"):
            after = [detector.feel(*reading), *(detector.feel(theta) for _ in range(5))]
        assert not np.isfinite([residual for _, residual, _ in after[:5]]).any()
        np.testing.assert_array_equal([contact for contact, _, _ in after], contact)
        np.testing.assert_array_equal(after[5], before)


def test_what_is_remembered_lies_in_the_context(shipped_finger, bent):
    layout = SensorLayout(shipped_finger, 2)
    block = ContactDetector(layout, GRAVITY, PERIOD)
    one, other, reference = Detector(layout, block), Detector(layout, block), Detector(layout)
    for theta in 0.1 * bent(8, 2):
        other.feel(theta + 0.2)
        np.testing.assert_array_equal(one.feel(theta), reference.feel(theta))


def first(flags):
    """Index of the first flag that is set."""
    assert flags.any()
    return int(np.argmax(flags))


@pytest.mark.parametrize("name", ["box_grasp", "irregular_grasp"])
@pytest.mark.parametrize("pressure", [50e3, 120e3])
def test_the_touch_of_an_object_is_felt_within_50_ms_and_not_before(name, pressure):
    short = ("pressure.settle=0.49", "pressure.hold_samples=1", f"pressure.steps.all=[0, {pressure}]")
    recording = simulate(load_scenario(name, [*short, f"sensor.contact_threshold={THRESHOLD}"]))
    for finger in FINGERS:
        contact, since = (recording[f"{finger}.{signal}"].values.squeeze() for signal in ("contact", "contact_time"))
        touched, felt = first(recording[f"{finger}.true_external_torque"].values.any(axis=1)), first(contact > 0)
        assert 0 <= (felt - touched) * PERIOD <= 0.05
        assert since[-1] == pytest.approx((felt - 1) * PERIOD)  # a recording shows the sample before
        assert contact[felt:].all()


@pytest.mark.parametrize("time_step", [0.01, 0.0025])
def test_in_free_air_each_sample_is_taken_once_and_no_step_of_the_pressure_for_contact(time_step):
    overrides = (f"plant_config.time_step={time_step}", f"sensor.contact_threshold={THRESHOLD}")
    station = make_station(free_bending([-60e3, 240e3, 0.0, 100e3, -60e3], 0.4, *overrides))
    recording = run_station(station)
    for finger in station.fingers:
        signals = ("theta", "sampled_pressure", "contact_residual", "contact", "contact_time", "true_external_torque")
        # A recording shows the sample before: the first is in its second row.
        theta, pressure, residual, *told = (recording[f"{finger.name}.{name}"].values[1:].squeeze() for name in signals)
        thetas, pressures = (sliding_window_view(signal, 5, axis=0) for signal in (theta, pressure))
        X_WB = np.broadcast_to(finger.X_WB.GetAsMatrix34(), (len(thetas), 5, 3, 4))
        motion = Motion(np.swapaxes(thetas, 1, 2), pressures, X_WB)
        expected, _ = contact_residual(BaseSection(SensorLayout(finger.finger, 4)), motion, GRAVITY, PERIOD)
        assert np.isnan(residual[:4]).all()
        np.testing.assert_allclose(residual[4:], expected, atol=1e-12)
        assert np.abs(expected).max() > THRESHOLD  # which the tolerance has to cover
        contact, since, truth = told
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


def carried_finger_feels(sections, time_step, torque, since):
    """Contact (1, T), and the static estimate of external torque (N, T), of a finger on the carriage.

    From `since` on, s, `torque` (N,) N m acts on its joints.
    """
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=time_step, use_sampled_output_ports=False), builder)
    carriage, frame = add_carriage(plant)
    expanded = expand_urdf(DIRECTORY / "grippers" / "finger.urdf")
    (finger,) = expanded.fingers
    Parser(plant).AddModelsFromString(expanded.text, "urdf")
    plant.WeldFrames(frame, plant.GetFrameByName("mount"), RigidTransform([0.1, 0.0, 0.1]))
    plant.Finalize()
    joints = [plant.GetJointByName(joint_name(finger.name, i)) for i in range(finger.segments)]
    base, layout = plant.GetBodyByName(link_name(finger.name, 0)).index(), SensorLayout(finger, sections)

    def add(system, *inputs):
        builder.AddSystem(system)
        for i, port in enumerate(inputs):
            builder.Connect(port, system.get_input_port(i))
        return system.get_output_port(0)

    motion = add(TrajectorySource(shaken(), output_derivative_order=1))
    builder.Connect(motion, plant.get_desired_state_input_port(carriage))
    forces = np.zeros((plant.num_velocities(), 2))
    forces[[joint.velocity_start() for joint in joints], 1] = torque
    force = add(TrajectorySource(PiecewisePolynomial.ZeroOrderHold([0.0, since, 9.0], forces[:, [0, 1, 1]])))
    builder.Connect(force, plant.get_applied_generalized_force_input_port())

    q = np.eye(plant.num_multibody_states())[[joint.position_start() for joint in joints]]
    strain = add(StrainSensor(layout, PERIOD), add(MatrixGain(q), plant.get_state_output_port())).get_system()
    X_WB = add(BasePoseSensor(base, PERIOD), plant.get_body_poses_output_port())
    theta = add(ArcPoseEstimator(layout), strain.GetOutputPort("strain"), X_WB)
    no_pressure = add(ConstantVectorSource([0.0]))
    contact = add(ContactDetector(layout, GRAVITY, PERIOD), theta, no_pressure, X_WB)
    static = add(ForceEstimator(layout, GRAVITY), theta, no_pressure, X_WB).get_system()
    ports = contact, static.GetOutputPort("external_torque")
    logs = [LogVectorOutput(port, builder, PERIOD) for port in ports]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(TIMES[-1])
    return [log.FindLog(simulator.get_context()).data() for log in logs]


@pytest.mark.parametrize("time_step", [0.01, 0.005])
@pytest.mark.parametrize("sections", [2, 4])
def test_a_touch_is_felt_while_the_base_is_shaken_and_nothing_before(shipped_finger, sections, time_step):
    """A force of 0.15 N at the tip that holds the finger open."""
    torque = -0.15 * (shipped_finger.length - shipped_finger.joint_arc_lengths)
    (contact,), static = carried_finger_feels(sections, time_step, torque, since=1.5)
    felt = first(contact > 0) - 1  # a log shows the sample before
    assert 1.5 <= felt * PERIOD <= 1.55
    assert np.abs(static[0, 10:150]).max() > 10 * THRESHOLD  # what shaking is taken for if inertia is not counted
