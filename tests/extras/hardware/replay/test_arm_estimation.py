"""Recordings as those of an arm, the arm that they move, and the sources of their samples."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial.transform import Rotation

from soft_gripper.diagrams.recording import read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.estimators.arcs import join_arcs
from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.extras.hardware.recordings import BodyPose, HardwareRecording
from soft_gripper.extras.hardware.replay.arm_estimation import (
    PERIOD,
    LogSource,
    RigidParts,
    StretchedArm,
    arm_recording,
    stretched_arm,
)
from soft_gripper.fingers.kinematics import as_points


@pytest.fixture
def recording():
    """Rows every 50 ms; a body turns by 0.3 rad about y in a second, and flips by half a turn in between."""
    time = 5.0 + 0.05 * np.arange(21)
    angle = 0.3 * (time - 5)
    half_turns = np.where((time > 5.3) & (time < 5.6), np.pi, 0.0)
    flipped = Rotation.from_rotvec(np.outer(angle, [0, 1, 0])) * Rotation.from_rotvec(np.outer(half_turns, [1, 0, 0]))
    still = np.broadcast_to(np.eye(3), (21, 3, 3))
    poses = {
        "base": BodyPose(np.zeros((21, 3)), still),
        "middle": BodyPose(
            np.tile([0.0, 0.0, 0.25], (21, 1)), flipped.as_matrix()
        ),  # further than "tip", by name before
        "tip": BodyPose(np.tile([0.01, 0.0, 0.12], (21, 1)), still),
    }
    config = load_description("two_segment_arm")
    lengths = {name: np.arange(21.0) + i for i, name in enumerate(config.lengths.wires)}
    return HardwareRecording("run", config, time, poses=poses, lengths=lengths, pressures=np.ones((21, 6)))


def test_rows_are_held(recording):
    arm = arm_recording(recording)
    np.testing.assert_allclose(np.diff(arm.time), PERIOD)
    rows = np.floor(arm.time / 0.05 + 1e-9)
    names = list(recording.config.lengths.wires)
    np.testing.assert_allclose(arm.inner[:, 0], rows + names.index("left_upper"))
    np.testing.assert_allclose(arm.outer[:, 1], rows + names.index("right_total"))
    assert arm.chamber_sections == (0, 0, 0, 1, 1, 1)


def test_half_turns_of_a_body_are_seen_through(recording):
    arm = arm_recording(recording)
    np.testing.assert_allclose(arm.headings[:, 1], 0.3 * np.floor(arm.time / 0.05 + 1e-9) * 0.05, atol=1e-9)


def test_rows_that_lack_a_reading_are_bridged_and_bodies_stay_unseen(recording):
    recording.pressures[4:6, 2] = np.nan
    recording.poses["middle"].R[10:12] = np.nan
    arm, whole = arm_recording(recording), np.arange(0.0, 1.0, PERIOD)
    assert np.isfinite(arm.inner).all()
    np.testing.assert_allclose(arm.inner[12], arm.inner[9])  # 0.24 s: as at 0.18 s, the last whole row
    lost = (whole > 0.499) & (whole < 0.599)
    np.testing.assert_array_equal(np.isnan(arm.headings[:, 1]), lost)
    assert arm.headings[-1, 1] == pytest.approx(0.3 * 0.95)


ENDS = np.array([0, 40, 80])
NOTHING = np.zeros(2, dtype=complex)


def parts(**numbers):
    return RigidParts(
        **{"base": 0j, "tilt": 0.0, "couplings": NOTHING, "bodies": NOTHING, "turns": np.zeros(2), **numbers}
    )


def shared(theta):
    return np.repeat(np.asarray(theta) / 40, 40, axis=-1)


def test_unequal_sections_lie_on_their_arcs():
    theta, length = np.array([[0.6, -0.8], [0.0, 0.3]]), np.array([[0.12, 0.17], [0.1, 0.13]])
    _, bodies, headings = stretched_arm(parts(), shared(theta), length, ENDS)
    np.testing.assert_allclose(bodies, join_arcs(theta, length).end, atol=1e-5)
    np.testing.assert_allclose(headings, theta.cumsum(axis=-1))


def test_rigid_parts_turn_with_what_carries_them():
    """Two right angles of the joint at 39, at the end of section 1: behind it all is seen from the other side."""
    q = np.zeros(80)
    q[39] = np.pi
    rigid = parts(couplings=np.array([0.02j, 0]), bodies=np.array([0.03, 0.01j]), turns=np.array([0.1, 0.0]))
    length = np.array([0.4, 0.4])
    _, bodies, headings = stretched_arm(rigid, q, length, ENDS)
    end = 0.395 - 0.005  # half of the last segment runs back
    np.testing.assert_allclose(bodies, [end - 0.03, end - 0.02j - 0.4 - 0.01j], atol=1e-12)
    np.testing.assert_allclose(headings, [np.pi + 0.1, np.pi])


def test_base_and_tilt_move_the_whole_arm():
    theta, length = shared([0.6, -0.8]), np.array([0.12, 0.17])
    joints, bodies, _ = stretched_arm(parts(), theta, length, ENDS)
    moved, moved_bodies, headings = stretched_arm(parts(base=0.01j, tilt=0.3), theta, length, ENDS)
    np.testing.assert_allclose(moved, 0.01j + joints * np.exp(0.3j))
    np.testing.assert_allclose(moved_bodies, 0.01j + bodies * np.exp(0.3j))
    assert headings[-1] == pytest.approx(0.3 - 0.2)


def test_the_block_puts_out_the_arm_and_how_far_its_bodies_are_from_the_measured_ones(shipped_finger, bent):
    finger, lengths = replace(shipped_finger, segments=80), np.array([0.12, 0.17])
    rigid, q = parts(base=0.01j, tilt=0.3, bodies=np.array([0.03, 0.01j])), bent(1, 80)[0] / 10
    arm = StretchedArm(rigid, finger, ["middle", "tip"])
    context = arm.CreateDefaultContext()
    joints, bodies, _ = stretched_arm(rigid, q, lengths, ENDS)
    off = np.array([3e-3 + 4e-3j, -5e-3j])
    inputs = q, lengths, as_points(bodies + off).ravel()
    for number, value in enumerate(inputs):
        arm.get_input_port(number).FixValue(context, value)
    found = {
        name: arm.GetOutputPort(name).Eval(context) for name in ("joint_positions", "body_positions", "body_error")
    }
    np.testing.assert_allclose(found["joint_positions"], as_points(joints).ravel(), atol=1e-12)
    np.testing.assert_allclose(found["body_positions"], as_points(bodies).ravel(), atol=1e-12)
    np.testing.assert_allclose(found["body_error"], [5e-3, 5e-3], atol=1e-12)


def test_samples_at_their_times():
    samples = np.arange(300.0).reshape(100, 3)
    builder = DiagramBuilder()
    source = builder.AddSystem(LogSource("wires", samples, 0.02, "m", wire=range(3)))
    logs = add_logs(builder, {"wires": source.get_output_port()}, 0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.5)
    recording = read_logs(logs, simulator.get_context())
    # A logged value is what a reader finds at that time: the sample before.
    expected = samples[np.minimum(np.maximum(np.arange(126) - 1, 0), 99)]
    np.testing.assert_array_equal(recording["wires"].values, expected)
    assert recording["wires"].attrs["units"] == "m"
