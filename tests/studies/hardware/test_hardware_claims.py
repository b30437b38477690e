"""Bars on hardware: they hold just within, and fail just beyond or where nothing is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from soft_gripper.extras.hardware.identification.fit import UNHELD, MotionScore
from soft_gripper.extras.hardware.identification.identified_finger import repetitions
from soft_gripper.extras.hardware.replay.held_out import ALL, ReplayRow
from soft_gripper.fingers.finger_parts import CreepBranch, TipLoad
from studies.hardware.published import hardware_claims

GOOD = MotionScore(
    "a",
    "test",
    settled_error_mm=1.4,
    motion_error_mm=2.4,
    tip_error_percent=4.9,
    settled_turn_deg=10,
    simulated_settled_turn_deg=10.7,
    creep_deg=2,
    simulated_creep_deg=2.3,
    recovery_deg=1.0,
    simulated_recovery_deg=1.1,
    t50_ms=100,
    simulated_t50_ms=114,
    t63_ms=130,
    simulated_t63_ms=118,
    frequency_hz=5.0,
    simulated_frequency_hz=5.09,
    decrement=0.40,
    simulated_decrement=0.45,
)
ARM = [
    ReplayRow("arcs", 2, ALL, "tip", 2.9, 2.0, 5.9, 20.0, 95.0, 1.0, 5.0, 0.0),
    ReplayRow("gaussian", 1, ALL, "tip", 9.9, 2.0, 30.0, 40.0, np.nan, 1.0, 5.0, 0.0),
    ReplayRow("arcs", 2, "trial_6", "tip", 4.9, 2.0, 5.9, 20.0, 90.5, 1.0, 5.0, 0.0),
    ReplayRow("arcs", 1, ALL, "tip", 12.0, 2.0, 5.9, 20.0, np.nan, 1.0, 5.0, 0.0),
    ReplayRow("gaussian", 2, ALL, "tip", 2.8, 2.0, 30.0, 40.0, np.nan, 1.0, 5.0, 0.0),
]


def identified(*rows, modulus=330e3, share=0.2, rms=0.039):
    """What claims look at of an identified finger."""
    finger = SimpleNamespace(base=SimpleNamespace(youngs_modulus=modulus), creep=(CreepBranch(share, 1.0),))
    fit = SimpleNamespace(error=rms)
    return SimpleNamespace(scores=rows, model=SimpleNamespace(finger=finger), fit=fit)


def failing(beam=GOOD, segment=GOOD, arm=ARM, fitted=None, unheld=GOOD, **finger):
    good_fit, bad_fit = replace(GOOD, role="fit"), replace(GOOD, role="fit", tip_error_percent=99.0, creep_deg=99.0)
    unheld = replace(unheld, role=UNHELD)
    found = hardware_claims(
        identified(fitted or good_fit, beam, unheld, **finger), identified(bad_fit, GOOD, segment), arm
    )
    return [claim.text for claim in found if not claim.holds]


def test_hold_within_their_bars_whatever_the_fit_is_off_by():
    assert not failing()


BEAM = {
    "settled markers": {"settled_error_mm": 1.6},
    "settled turn": {"simulated_settled_turn_deg": 8.9},
    "frequency": {"simulated_frequency_hz": 4.8},
    "decrement": {"simulated_decrement": np.nan},
    "decrement ": {"simulated_decrement": 0.33},
}
SEGMENT = {
    "settled turn": {"simulated_settled_turn_deg": 9.1},
    "creep": {"simulated_creep_deg": 1.2},
    "recovery": {"simulated_recovery_deg": 1.16},
    "recovery ": {"simulated_recovery_deg": np.nan},
    "times": {"simulated_t50_ms": 121},
    "times ": {"t63_ms": np.nan},
    "tip": {"tip_error_percent": 5.1},
}
ROWS = [
    (0, {"mean_mm": 3.1}),
    (0, {"percentile_95_mm": 6.1}),
    (1, {"mean_mm": 11}),
    (2, {"mean_mm": 5.1}),
    (2, {"within_band_percent": 89.0}),
    (4, {"mean_mm": 3.0}),
]


def test_each_fails_beyond_in_one_recording():
    """A decrement that is held out is judged by the spread of two repetitions, see below."""
    found = {}
    for text, change in BEAM.items():
        bad = replace(GOOD, **change)
        found[f"beam, 101 g, held out: {text}"] = failing(beam=bad)
        found[f"beam, fitted: {text}"] = failing(fitted=replace(bad, role="fit"))
        found[f"beam, 101 g, held out, hold unknown: {text}"] = failing(unheld=bad)
    found |= {f"segment: {text}": failing(segment=replace(GOOD, **change)) for text, change in SEGMENT.items()}
    for row, change in ROWS:
        table = [replace(of, **change) if i == row else of for i, of in enumerate(ARM)]
        found[f"arm: {' ' * len(found)}"] = failing(arm=table)
    for text, failed in found.items():
        assert len(failed) == 1, text
        assert failed[0].startswith(text.strip())


@pytest.mark.parametrize(
    ("simulated", "holds"), [(0.33, False), (0.35, True), (0.43, True), (0.52, True), (0.54, False)]
)
def test_a_held_out_decrement_is_judged_by_the_spread_of_two_repetitions(simulated, holds):
    """0.40 was recorded, and 0.46 in a repetition."""
    failed = failing(beam=replace(GOOD, simulated_decrement=simulated))
    assert failed == [] if holds else failed[0].endswith("within 15 % of two repetitions, 0.40 and 0.46")


def test_the_modulus_is_the_one_that_creep_leaves():
    (failed,) = failing(share=0.0)
    assert failed.startswith("beam: modulus")


def test_claims_of_the_arm_are_those_of_its_last_body():
    """The table goes from the base to the tip."""
    middle = [replace(row, body="middle", mean_mm=99.0, percentile_95_mm=99.0) for row in ARM]
    assert failing(arm=[*middle, *ARM]) == []
    assert len(failing(arm=[*ARM, *middle])) == 4


def test_recordings_under_the_same_load_say_how_much_they_differ():
    """A hand that is unknown is another comparison with the same recording, no repetition."""
    loaded, unloaded = (SimpleNamespace(pressure=None, load=load) for load in (TipLoad(0.1, 0.015, 0.0), None))
    again = replace(GOOD, recording="b", decrement=0.46, settled_turn_deg=10.5)
    rows = [
        (GOOD, loaded),
        (replace(GOOD, role=UNHELD), loaded),
        (again, loaded),
        (replace(GOOD, recording="c"), unloaded),
    ]
    scores, motions = zip(*rows, strict=True)
    (text,) = repetitions(SimpleNamespace(scores=scores, motions=motions))
    assert text == "a and b repeat each other: settled turn 10.00 to 10.50 degrees, decrement 0.40 to 0.46"
