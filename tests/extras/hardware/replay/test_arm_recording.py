"""Recordings of hardware as those of an arm: samples held, bodies in order, headings without a sign."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.spatial.transform import Rotation

from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.extras.hardware.recordings import BodyPose, HardwareRecording
from soft_gripper.extras.hardware.replay.arm_estimation import PERIOD, arm_recording


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


def test_bodies_go_from_the_base_on(recording):
    arm = arm_recording(recording)
    assert arm.bodies == ("tip", "middle")
    np.testing.assert_allclose(arm.positions[0], [0.12 + 0.01j, 0.25])


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


def test_what_is_missing_is_named(recording):
    with refused("poses", []):
        arm_recording(replace(recording, poses={"base": recording.poses["base"]}))
    with refused("pressures", None):
        arm_recording(replace(recording, pressures=None))
    config = replace(recording.config, pressures=replace(recording.config.pressures, sections=[1, 1, 1, 2, 2, 3]))
    with refused("pressures.sections", [1, 1, 1, 2, 2, 3]):
        arm_recording(replace(recording, config=config))
    config = replace(recording.config, lengths=None)
    with refused("lengths", None):
        arm_recording(replace(recording, config=config))
