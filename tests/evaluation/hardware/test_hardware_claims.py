"""Bars on hardware: they hold just within, and fail just beyond or where nothing is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from soft_gripper.evaluation.hardware import hardware_claims
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.hardware.identification.fit import MotionScore
from soft_gripper.hardware.replay.held_out import ALL, ReplayRow

GOOD = MotionScore("a", "test", 1.9, 2.4, 4.9, 10, 10.9, 2, 2.5, 100, 128, 5.0, 5.14, 0.40, 0.45)
ARM = [
    ReplayRow("arcs", 2, ALL, "tip", 2.9, 2.0, 5.9, 20.0),
    ReplayRow("gaussian", 1, ALL, "tip", 9.9, 2.0, 30.0, 40.0),
]


def identified(*rows, modulus=330e3, share=0.2):
    """What claims look at of an identified finger."""
    finger = SimpleNamespace(base=SimpleNamespace(youngs_modulus=modulus), creep=(CreepBranch(share, 1.0),))
    return SimpleNamespace(scores=rows, model=SimpleNamespace(finger=finger))


def failing(beam=GOOD, segment=GOOD, arm=ARM, **finger):
    bad_fit = replace(GOOD, role="fit", settled_error_mm=99.0, tip_error_percent=99.0)
    found = hardware_claims(identified(bad_fit, beam, **finger), identified(bad_fit, GOOD, segment), arm)
    return [claim.text for claim in found if not claim.holds]


def test_hold_within_their_bars_whatever_the_fit_is_off_by():
    assert not failing()


@pytest.mark.parametrize(
    ("text", "change"),
    [
        ("beam: settled", {"settled_error_mm": 2.1}),
        ("beam: whole motion", {"motion_error_mm": 2.6}),
        ("beam: frequency", {"simulated_frequency_hz": 4.8}),
        ("beam: decrement", {"simulated_decrement": 0.33}),
        ("beam: decrement", {"simulated_decrement": np.nan}),
    ],
)
def test_each_of_the_beam_fails_beyond(text, change):
    (failed,) = failing(beam=replace(GOOD, **change))
    assert failed.startswith(text)


@pytest.mark.parametrize(
    ("text", "change"),
    [
        ("segment: settled turn", {"simulated_settled_turn_deg": 8.9}),
        ("segment: creep", {"simulated_creep_deg": 1.3}),
        ("segment: rise", {"simulated_rise_ms": 131}),
        ("segment: rise", {"rise_ms": np.nan}),
        ("segment: tip", {"tip_error_percent": 5.1}),
    ],
)
def test_each_of_the_segment_fails_beyond_in_one_recording(text, change):
    (failed,) = failing(segment=replace(GOOD, **change))
    assert failed.startswith(text)


def test_the_modulus_is_the_one_that_creep_leaves():
    (failed,) = failing(share=0.0)
    assert failed.startswith("beam: modulus")


@pytest.mark.parametrize(
    ("row", "change"), [(0, {"mean_mm": 3.1}), (0, {"percentile_95_mm": 6.1}), (1, {"mean_mm": 11})]
)
def test_each_of_the_arm_fails_beyond(row, change):
    table = [replace(of, **change) if i == row else of for i, of in enumerate(ARM)]
    (failed,) = failing(arm=table)
    assert failed.startswith("arm:")


def test_claims_of_the_arm_are_those_of_its_last_body():
    """The table goes from the base to the tip."""
    middle = [replace(row, body="middle", mean_mm=99.0, percentile_95_mm=99.0) for row in ARM]
    assert failing(arm=[*middle, *ARM]) == []
    assert len(failing(arm=[*ARM, *middle])) == 3
