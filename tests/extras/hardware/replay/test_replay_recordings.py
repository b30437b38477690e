"""Replays: protocol, leakage, the table, and the published recordings."""

from dataclasses import replace

import numpy as np
import pytest
from hardware_files import published
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.extras.hardware.replay.arm_estimation import arm_recording, stretched_arm
from soft_gripper.extras.hardware.replay.held_out import ALL, estimator_rows, replay_recordings, replay_table
from soft_gripper.fingers.kinematics import as_points

DOWN = np.array([0.0, 0.0, 9.81])
ROWS = {"arcs 1": ("arcs", 1), "arcs 2": ("arcs", 2), "gaussian 1": ("gaussian", 1)}


@pytest.fixture(scope="module")
def replayed(arms, arm_finger):
    return replay_recordings(arms, None, ROWS, arm_finger, DOWN).replayed


@pytest.mark.slow
def test_two_arcs_find_an_arm_of_two_arcs(replayed):
    table = {(row.estimator, row.sections): row for row in replay_table(replayed, ROWS) if _is_tip(row)}
    assert table["arcs", 2].mean_mm < 1.5
    assert table["arcs", 1].mean_mm > 20  # bent twice, either way
    assert table["gaussian", 1].mean_mm < 10


def _is_tip(row):
    return row.body == "tip" and row.recording == ALL


@pytest.mark.slow
def test_the_blocks_do_what_the_functions_do(arms, replayed, arm_finger):
    arm, recording = replayed[1].fitted.arm, arms[1]
    theta, length = arm.wires.sections(recording.inner, recording.outer)
    _, bodies, _ = stretched_arm(arm.parts, np.repeat(theta / 6, 6, axis=-1), length, arm_finger.section_ends(2))
    logged = replayed[1].signals["arcs 2.body_positions"].values[1:]  # each as a reader finds it: the sample before
    np.testing.assert_allclose(logged, as_points(bodies)[: len(logged)], atol=1e-4)


@pytest.mark.slow
def test_what_an_arm_is_uncertain_by_follows_from_its_recordings(arms, replayed):
    """The noise of the wires was made; a usual load bends a tenth as far as the drive leaves unexplained.

    A sixth of the samples is in motion, so that the median step is at most the 60th percentile of noise: 1.25 times.
    """
    found = replayed[1].fitted.arm
    length = np.mean([arms[i].inner[:, -1].mean() for i in (0, 2, 3)])
    assert 0.98e-4 / length < found.uncertainty.reading < 1.25e-4 / length
    bend = found.uncertainty.load_pressure * found.finger.pressure_gain[0] / found.finger.stiffness[0]
    assert bend == pytest.approx(0.1 * found.uncertainty.angle)


@pytest.mark.slow
def test_motion_capture_of_what_is_estimated_changes_nothing(arms, arm_finger, replayed):
    moved = replace(arms[0], positions=arms[0].positions + 0.03, headings=arms[0].headings + 0.1)
    again = replay_recordings([moved], arms[1:], ROWS, arm_finger, DOWN).replayed[0]
    for row in ROWS:
        name = f"{row}.body_positions"
        np.testing.assert_array_equal(again.signals[name].values, replayed[0].signals[name].values)
    assert again.signals["arcs 2.body_error"].values[1:].min() > 0.02


def test_zeroed_wires_place_the_bodies_again_and_their_first_seconds_are_not_scored(arms, arm_finger):
    moved = replace(arms[0], inner=arms[0].inner + np.array([0.02, -0.01]))
    rows = {"arcs 2": ("arcs", 2)}
    plain, zeroed = (replay_recordings([moved], arms[1:], rows, arm_finger, DOWN, zero) for zero in (0.0, 0.5))
    assert [found.replayed[0].first for found in (plain, zeroed)] == [1, 27]
    errors = [found.table[-1].mean_mm for found in (plain, zeroed)]
    assert errors[0] > 10 > 2 > errors[1]
    assert zeroed.table[-1].within_band_percent > 90


def test_what_is_reported_is_not_fitted_to(arms, arm_finger):
    with pytest.raises(InputError) as caught:
        replay_recordings(arms[:2], arms[1:], ROWS, arm_finger, DOWN)
    assert (caught.value.field, caught.value.value) == ("--fit", ["run_1"])
    with refused("FILE", ["run_0"]):
        replay_recordings(arms[:1], None, ROWS, arm_finger, DOWN)


def test_estimators_by_name():
    assert list(estimator_rows(["arcs", "gaussian"], 2)) == ["arcs 1", "gaussian 1", "arcs 2", "gaussian 2"]
    own = "own_blocks:contact_again"
    assert estimator_rows([own], 2) == {f"{own} 1": (own, 1), f"{own} 2": (own, 2)}
    with refused("--estimator", "arks"):
        estimator_rows(["arks"], 2)


@pytest.mark.slow
def test_the_published_arm(arm_finger):
    folder = published("two_segment_arm")
    files = [str(folder / f"trial_{i}.txt") for i in range(1, 6)]
    recordings = find_recordings(files, "two_segment_arm")
    rows = {"arcs 2": ("arcs", 2)}
    arms = [arm_recording(recording) for recording in recordings]
    (tip,) = (row for row in replay_recordings(arms, None, rows, arm_finger, DOWN).table if _is_tip(row))
    assert tip.mean_mm < 2.6
    assert tip.percentile_95_mm < 5.6
