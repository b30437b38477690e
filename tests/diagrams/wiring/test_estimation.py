"""The estimation of a finger: alone on given measurements, with a user's own estimator, and what is none."""

import numpy as np
import pytest
from own_blocks import MeanBend
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.estimation import FingerEstimation
from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.errors import InputError
from soft_gripper.estimators.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.estimators.plane import planar_gravity, pose_entries
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, gravity_torque
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.signals import signal_of

GRAVITY, PERIOD = np.array([0.5, -1.0, -9.0]), 0.01  # m/s^2, s
X_WB = RigidTransform(RollPitchYaw(2.0, 0.3, -0.4), [0.1, 0.2, 0.3])
PRESSURE = 50e3  # Pa
SHORT = ["pressure.steps.all=[60e3]", "pressure.settle=0.3", "pressure.hold_samples=1"]


@pytest.fixture(scope="module")
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 4)


def balanced(layout, load):
    """Joint angles at which stiffness bears pressure, weight and a load, N m."""
    gravity, finger = planar_gravity(pose_entries(X_WB), GRAVITY), layout.finger
    q = np.zeros(finger.segments)
    for _ in range(30):
        weight = gravity_torque(finger, q, gravity)
        q = (PRESSURE * finger.pressure_gain + weight + load) / finger.stiffness
    return q


def estimated(layout, q, samples, threshold=None):
    """What is estimated after some samples of a finger that rests at q."""
    estimation = FingerEstimation(ArcPoseEstimator(layout, GRAVITY), layout, GRAVITY, PERIOD, threshold)
    simulator = Simulator(estimation)
    context = simulator.get_mutable_context()
    strain = layout.response.reading(extension_ratios(layout, q))
    for name, value in (("strain", strain), ("pressure", [PRESSURE]), ("X_WB", pose_entries(X_WB))):
        estimation.GetInputPort(name).FixValue(context, value)
    simulator.AdvanceTo((samples - 1) * PERIOD + PERIOD / 2)
    return {name: port.Eval(context) for name, port in vector_outputs(estimation).items()}


def test_on_measurements_alone_it_finds_shape_and_load(layout):
    """A load that is linear along the finger, on one that hangs askew."""
    load = -0.01 * (1 - layout.finger.joint_arc_lengths / layout.finger.length)
    q = balanced(layout, load)
    found = estimated(layout, q, 5)
    np.testing.assert_allclose(found["estimated_joint_angles"], q, atol=1e-4)
    np.testing.assert_allclose(found["external_torque"], load, atol=1e-4)
    truth = forward_kinematics(q, layout.finger.segment_length)
    assert np.abs(found["joint_positions"].reshape(-1, 2) - as_points(truth.joints)).max() < 5e-4
    world = (X_WB @ np.insert(found["joint_positions"].reshape(-1, 2), 1, 0.0, axis=1).T).T
    np.testing.assert_allclose(found["joint_positions_world"].reshape(-1, 3), world, atol=1e-12)


@pytest.mark.parametrize(("load", "touches"), [(0.0, 0.0), (-0.01, 1.0), (0.01, 1.0)])
def test_contact_is_looked_for_with_a_threshold(layout, load, touches):
    q = balanced(layout, load * (1 - layout.finger.joint_arc_lengths / layout.finger.length))
    found = estimated(layout, q, 6, threshold=2.5e-3)
    assert found["contact"] == [touches]
    assert found["contact_residual"] == pytest.approx(found["external_torque"][:3].mean())
    assert "contact" not in estimated(layout, q, 1)


@pytest.fixture(scope="module")
def own():
    """A station whose estimator is the user's, and what it recorded."""
    station = make_station(load_scenario("free_bending", [*SHORT, "estimator.type=own_blocks:mean_bend"]))
    return station, run_station(station)


def test_what_a_users_estimator_leaves_out_follows_from_its_joint_angles(own):
    station, recording = own
    for finger in station.fingers:
        found = {name: recording[f"{finger.name}.{name}"].values for name in ("joint_positions", "tip_pose", "arcs")}
        q = recording[f"{finger.name}.estimated_joint_angles"].values
        chain = forward_kinematics(q, finger.finger.segment_length)
        np.testing.assert_allclose(found["joint_positions"], as_points(chain.joints), atol=1e-12)
        np.testing.assert_allclose(found["tip_pose"][:, :2], as_points(chain.tip), atol=1e-12)
        assert found["arcs"].shape[1:] == (12, 7)  # an arc a segment
        assert recording[f"{finger.name}.pose_error"].values[-1] < 1e-3
        assert np.isfinite(recording[f"{finger.name}.external_torque"].values[-1]).all()
        assert f"{finger.name}.theta" not in recording.data


def test_an_estimator_of_the_call_takes_the_place_of_the_scenarios(own):
    """It is made for the nominal model, for gravity as it is compensated, and for the period of the samples."""
    made = []

    def make(layout, gravity, period):
        made.append((layout.finger.length, layout.sections, gravity.tolist(), period))
        return MeanBend(layout)

    overrides = [*SHORT, "nominal.finger.length=0.13", "sensor.period=0.02", "sensor.sections=2"]
    make_station(load_scenario("free_bending", overrides), make_estimator=make)
    make_station(load_scenario("free_bending", [*overrides, "estimator.compensate_gravity=false"]), make_estimator=make)
    assert made == [(0.13, 2, [0, 0, -9.81], 0.02)] * 2 + [(0.13, 2, [0, 0, 0], 0.02)] * 2
    _, by_name = own
    scenario = load_scenario("free_bending", SHORT)
    by_call = run_station(make_station(scenario, make_estimator=lambda layout, *others: MeanBend(layout)))
    np.testing.assert_array_equal(by_call["left_finger.tip_pose"], by_name["left_finger.tip_pose"])


class Port(LeafSystem):
    """Declares ports, inputs and outputs by their sizes, and puts out ones."""

    def __init__(self, inputs=None, **outputs):
        super().__init__()
        for name, size in (inputs or {}).items():
            self.DeclareVectorInputPort(name, size)
        for name, size in outputs.items():
            self.DeclareVectorOutputPort(name, size, lambda context, value: value.SetFromVector(np.ones(value.size())))


def test_what_an_estimator_knows_better_is_its_own(layout):
    estimation = FingerEstimation(Port(estimated_joint_angles=12, tip_pose=3, quality=2), layout, GRAVITY, PERIOD)
    context = estimation.CreateDefaultContext()
    estimation.GetInputPort("X_WB").FixValue(context, pose_entries(X_WB))
    estimation.GetInputPort("pressure").FixValue(context, [0.0])
    assert estimation.GetOutputPort("tip_pose").Eval(context).tolist() == [1, 1, 1]
    chain = forward_kinematics(np.ones(12), layout.finger.segment_length)
    joints = estimation.GetOutputPort("joint_positions").Eval(context).reshape(-1, 2)
    np.testing.assert_allclose(joints, as_points(chain.joints), atol=1e-12)
    assert estimation.GetOutputPort("quality").size() == 2
    assert signal_of(estimation.GetOutputPort("external_torque")).unit == "N m"


@pytest.mark.parametrize(
    ("estimator", "complaint"),
    [
        (Port(joint_angles=12), "estimator: output ports = 'joint_angles (12)': output 'estimated_joint_angles' (12)"),
        (Port({"strain": 3}, estimated_joint_angles=12), "estimator: input port 'strain' = 3: the signal with"),
        (Port({"weather": 1}, estimated_joint_angles=12), "estimator: input port = 'weather': an estimator may take"),
        (Port(estimated_joint_angles=12, strain=8), "finger: output ports = 'strain': have the name of another signal"),
    ],
)
def test_what_is_no_estimator(estimator, complaint):
    scenario = load_scenario("free_bending", SHORT)
    del scenario.models[1]
    with pytest.raises(InputError) as caught:
        make_station(scenario, make_estimator=lambda layout, gravity, period: estimator)
    assert complaint in str(caught.value)
