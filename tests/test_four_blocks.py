"""StrainSensor, ArcPoseEstimator, ForceEstimator and PidController: wired by hand, and those of shipped scenarios."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, MatrixGain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

import soft_gripper as sg
from soft_gripper import ArcPoseEstimator, ForceEstimator, PidController, StrainSensor
from soft_gripper.sensors.base_pose import FixedBasePose

PERIOD, DURATION, STEP = 0.01, 0.5, 0.25  # s; the set point steps in the middle
PRESSURE, FORCE = 40e3, -0.05  # Pa; N on the tip, which opens the finger
KP, KI, FIRST = 2e4, 5e5, 1e4  # Pa/rad, Pa/(rad s), Pa
SET_POINTS = 0.4, 0.7  # rad


def closed_form_strain(finger, q, sections):
    """Strain of paths at the offsets o along equal sections of joint angles, path after path.

    Over a segment of length h, that bends by q in its middle, a path covers twice half a segment, less o sin(q / 2)
    along the link and o (1 - cos(q / 2)) across it.
    """
    h, o = finger.segment_length, np.array(finger.sensor_offsets)[:, None]
    lengths = 2 * np.hypot(h / 2 - o * np.sin(q / 2), o * (1 - np.cos(q / 2)))
    return lengths.reshape(2, sections, -1).sum(axis=-1) * sections / finger.length - 1


@pytest.fixture
def run(shipped_finger):
    """The four blocks on joints that rest: what Drake's loggers hold, by name, (T, size) each."""

    def wired(q, sections):
        layout = sg.sensors.SensorLayout(shipped_finger, sections)
        builder, gravity = DiagramBuilder(), np.zeros(3)
        add, wire = builder.AddSystem, builder.Connect
        joints, base = add(ConstantVectorSource(q)), add(FixedBasePose(RigidTransform()))
        pressure = add(ConstantVectorSource([PRESSURE]))
        driving = add(sg.estimators.DrivingTorque(shipped_finger, PERIOD))
        sensor, pose = add(StrainSensor(layout, PERIOD)), add(ArcPoseEstimator(layout, gravity))
        force = add(ForceEstimator(shipped_finger, gravity, PERIOD))
        bend = add(MatrixGain([[0, 0, 1]]))
        target = add(TrajectorySource(PiecewisePolynomial.ZeroOrderHold([0, STEP, 1], [[*SET_POINTS, 0]])))
        pid = add(PidController(sg.control.PidGains(KP, KI), PERIOD, -1e6, 1e6, FIRST))
        wire(joints.get_output_port(), sensor.GetInputPort("joint_angles"))
        wire(pressure.get_output_port(), driving.GetInputPort("pressure"))
        wire(sensor.GetOutputPort("strain"), pose.GetInputPort("strain"))
        angles = "estimated_joint_angles"
        wire(pose.GetOutputPort(angles), force.GetInputPort(angles))
        for block in (pose, force):
            wire(driving.get_output_port(), block.GetInputPort("driving_torque"))
            wire(base.get_output_port(), block.GetInputPort("X_WB"))
        wire(pose.GetOutputPort("tip_pose"), bend.get_input_port())
        wire(bend.get_output_port(), pid.GetInputPort("measurement"))
        wire(target.get_output_port(), pid.GetInputPort("set_point"))
        blocks = {"strain": sensor, "tip_pose": pose, "external_torque": force, "output": pid}
        sinks = {port: LogVectorOutput(block.GetOutputPort(port), builder, PERIOD) for port, block in blocks.items()}
        simulator = Simulator(builder.Build())
        simulator.AdvanceTo(DURATION)
        return {name: sink.FindLog(simulator.get_context()).data().T for name, sink in sinks.items()}

    return wired


@pytest.mark.parametrize("sections", [1, 2, 3, 4])
def test_a_finger_of_constant_curvature_is_sensed_drawn_and_controlled(run, shipped_finger, sections):
    finger, q = shipped_finger, np.full(12, 0.05)
    logs, strain = run(q, sections), closed_form_strain(shipped_finger, q, sections)
    np.testing.assert_allclose(logs["strain"], np.tile(strain.ravel(), (51, 1)), rtol=0, atol=1e-14)

    # One arc: the bend from the difference of the two paths, the length on the axis between them.
    inner, outer = finger.length * (1 + strain.mean(axis=1))
    inner_offset, outer_offset = finger.sensor_offsets
    theta = (outer - inner) / (inner_offset - outer_offset)
    radius = (inner + theta * inner_offset) / theta
    pose = radius * (1 - np.cos(theta)), radius * np.sin(theta), theta
    np.testing.assert_allclose(logs["tip_pose"], np.tile(pose, (51, 1)), rtol=0, atol=1e-12)
    assert theta == pytest.approx(q.sum(), rel=2e-4)

    # u = kp e + I, I the integral of e by Euler's method, from where the first output is the initial one.
    error = np.where(np.arange(51) * PERIOD < STEP - 1e-9, *SET_POINTS) - theta
    integral = KI * PERIOD * (np.cumsum(error) - error)
    np.testing.assert_allclose(logs["output"][:, 0], FIRST + KP * (error - error[0]) + integral, rtol=0, atol=1e-9)


@pytest.mark.parametrize("sections", [1, 2, 3, 4])
def test_the_force_that_bends_a_finger_is_estimated(run, shipped_finger, sections):
    """A force across the tip has the torque F (L - s) about a joint at s, beside that of the pressure."""
    finger = shipped_finger
    torque = FORCE * (finger.length - finger.joint_arc_lengths)
    logs = run(sg.fingers.free_bending_angles(finger, PRESSURE) + torque / finger.stiffness, sections)
    assert np.isnan(logs["external_torque"][:4]).all(), "five samples balance"
    found = logs["external_torque"][5:]
    np.testing.assert_allclose(found, np.tile(torque, (len(found), 1)), rtol=0, atol=1e-3 * np.abs(torque).max())


def leaves(system):
    if isinstance(system, Diagram):
        return [leaf for inner in system.GetSystems() for leaf in leaves(inner)]
    return [system]


def test_other_sensors_and_estimators_have_the_general_blocks():
    changes = ["sensor.type=curvature", "estimator.type=gaussian"]
    found = {type(leaf) for leaf in leaves(sg.make_station(sg.load_scenario("free_bending", changes)).diagram)}
    assert {sg.sensors.SensorBlock, sg.estimators.ShapeEstimator} <= found
    assert not {StrainSensor, ArcPoseEstimator} & found
