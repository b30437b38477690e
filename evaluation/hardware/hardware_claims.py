"""What has to hold of fingers identified and arms estimated on hardware: on recordings that no fit was given."""

from collections.abc import Callable, Sequence

import numpy as np

from soft_gripper.evaluation.identify.identify import Identified
from soft_gripper.evaluation.identify.motion_scores import MotionScore
from soft_gripper.evaluation.paper.claims import Claim
from soft_gripper.evaluation.replay.replay_table import ALL, ReplayRow

_PUBLISHED_MODULUS = 263.8e3  # Pa, that the authors of the beam's recordings fitted by finite elements


def hardware_claims(beam: Identified, segment: Identified, arm: Sequence[ReplayRow]) -> list[Claim]:
    """All of them."""
    return _of_beam(beam) + _of_segment(segment) + _of_arm(arm)


def _of_beam(found: Identified) -> list[Claim]:
    (test,) = _tests(found)
    frequency = _off(test.simulated_frequency_hz, test.frequency_hz)
    decrement = _off(test.simulated_decrement, test.decrement)
    finger = found.model.finger
    relaxed = finger.base.youngs_modulus * (1 - sum(branch.share for branch in finger.creep))
    modulus = _off(relaxed, _PUBLISHED_MODULUS)
    settled, motion = test.settled_error_mm, test.motion_error_mm
    hertz = f"{test.simulated_frequency_hz:.2f} for {test.frequency_hz:.2f} Hz"
    decrements = f"{test.simulated_decrement:.2f} for {test.decrement:.2f}"
    return [
        _claim("beam: settled markers within 2 mm", settled <= 2.0, f"{settled:.2f} mm"),
        _claim("beam: whole motion within 2.5 mm (mean)", motion <= 2.5, f"{motion:.2f} mm"),
        _claim("beam: frequency within 3 %", frequency <= 0.03, f"{100 * frequency:.1f} %, {hertz}"),
        _claim("beam: decrement within 15 %", decrement <= 0.15, f"{100 * decrement:.0f} %, {decrements}"),
        _claim(
            "beam: modulus once creep is over within 10 % of the published",
            modulus <= 0.1,
            f"{100 * modulus:.1f} %, {1e-3 * relaxed:.0f} kPa",
        ),
    ]


def _of_segment(found: Identified) -> list[Claim]:
    turn = _worst(found, lambda row: _off(row.simulated_settled_turn_deg, row.settled_turn_deg))
    creep = _worst(found, lambda row: _off(row.simulated_creep_deg, row.creep_deg))
    rise = _worst(found, lambda row: _off(row.simulated_rise_ms, row.rise_ms))
    tip = _worst(found, lambda row: row.tip_error_percent)
    return [
        _claim("segment: settled turn within 10 %", turn <= 0.1, f"{100 * turn:.1f} %"),
        _claim("segment: creep within 30 %", creep <= 0.3, f"{100 * creep:.0f} %"),
        _claim("segment: rise time within 30 %", rise <= 0.3, f"{100 * rise:.0f} %"),
        _claim("segment: tip within 5 % of the length at all times", tip <= 5, f"{tip:.1f} %"),
    ]


def _of_arm(table: Sequence[ReplayRow]) -> list[Claim]:
    tip = table[-1].body
    of = {(row.estimator, row.sections): row for row in table if (row.recording, row.body) == (ALL, tip)}
    arcs, late, gaussian = of["arcs", 2].mean_mm, of["arcs", 2].percentile_95_mm, of["gaussian", 1].mean_mm
    return [
        _claim("arm: two arcs find the tip within 3 mm (mean)", arcs <= 3.0, f"{arcs:.2f} mm"),
        _claim("arm: two arcs find the tip within 6 mm (95th percentile)", late <= 6.0, f"{late:.2f} mm"),
        _claim("arm: gaussian, one sensor a side, within 10 mm (mean)", gaussian <= 10.0, f"{gaussian:.2f} mm"),
    ]


def _tests(found: Identified) -> list[MotionScore]:
    return [row for row in found.scores if row.role == "test"]


def _worst(found: Identified, error: Callable[[MotionScore], float]) -> float:
    """Over the recordings that test; NaN if one is."""
    return float(np.max([error(row) for row in _tests(found)]))


def _off(simulated: float, measured: float) -> float:
    """Relative."""
    return abs(simulated / measured - 1)


def _claim(text: str, holds: bool, number: str) -> Claim:
    return Claim("ours", text, bool(holds), number)
