"""How often what is stated of a contact is true: the rows, the situations, and the study on few contacts."""

import numpy as np
import pytest

from studies.contacts.contact_coverage import (
    COLUMNS,
    coverage_row,
)
from studies.contacts.estimates import Estimates
from studies.contacts.situations import PEG, STATICS, peg_estimates, static_estimates
from studies.estimator_setup import EstimatorSetup

IDEAL = EstimatorSetup(4)


def estimates(count, **changes):
    """Contacts of 1 N in the fourth tenth, which are found without an error."""
    one, ends = np.ones(count), np.array([0.9, 1.0, 1.1])
    exact = Estimates(
        force=one,
        location=0.35 * one,
        transverse=one,
        estimated_force=one,
        force_std=0.1 * one,
        estimated_location=0.35 * one,
        location_std=0.1 * one,
        estimated_transverse=one,
        transverse_std=0.1 * one,
        degrees=np.nan * one,
        probability=one,
        interval=ends * one[:, None],
        bounds=np.array([1.1, 1.1, 1.2]) * one[:, None],
        location_set=np.array([0.3, 0.4]) * one[:, None],
        transverse_interval=ends * one[:, None],
    )
    return exact._replace(**changes)


def test_a_row_has_the_share_of_what_is_stated_that_is_true():
    force = np.where(np.arange(40) < 10, 1.15, 1.0)
    row = coverage_row("at rest", IDEAL, estimates(40, force=force, estimated_force=force + 0.2))
    assert (row.contacts, row.withheld_percent, row.unbounded_percent) == ("40", "0.0", "0.0")
    assert row.interval_percent == row.bound_percent == row.bound_beyond_percent == "75.0"
    assert row.bound_several_percent == row.place_percent == "100.0"
    assert row.interval_by_tenth.split()[2] == row.interval_least_percent == "75.0"
    assert row.force_n_mean_middle == "nan"
    assert row.force_n_mean_near == row.force_n_90_near == "0.2"
    assert tuple(vars(row)) == COLUMNS


def test_widths_scores_and_errors_of_the_transverse_force_are_relative():
    """Of contacts that are detected; an interval that misses by 0.15 N scores 40 times that, in the mean of all."""
    true = np.where(np.arange(40) < 30, 1.25, 1.0)
    changes = {"transverse": true, "estimated_transverse": true + 0.1, "transverse_std": np.full(40, 0.05)}
    row = coverage_row("at rest", IDEAL, estimates(40, **changes))
    assert row.interval_width_near == row.interval_score_near == "0.2"
    assert (row.transverse_percent, row.transverse_width_near) == ("25.0", "0.16")
    assert float(row.transverse_score_near) == pytest.approx(0.75 * (0.2 + 40 * 0.15) / 1.25 + 0.25 * 0.2, abs=0.01)
    assert row.transverse_rms_z == "2"
    assert row.transverse_width_far == "nan"
    unseen = coverage_row("at rest", IDEAL, estimates(40, probability=np.full(40, 0.5)))
    assert unseen.transverse_width_near == unseen.transverse_rms_z == "nan"


def test_what_is_withheld_or_unbounded_is_counted_by_itself():
    nothing = np.where(np.arange(40)[:, None] < 30, np.nan, estimates(40).interval)
    bounds = np.where(np.arange(40)[:, None] < 30, [10.0, 10.0, 0.5], estimates(40).bounds)
    row = coverage_row("at rest", IDEAL, estimates(40, interval=nothing, bounds=bounds))
    assert (row.withheld_percent, row.unbounded_percent, row.interval_percent) == ("75.0", "75.0", "100.0")
    assert row.interval_least_percent == "inf", "ten are too few for a share of a tenth"
    assert (row.bound_percent, row.bound_several_percent) == ("100.0", "25.0")


@pytest.mark.parametrize("situation", STATICS)
def test_forces_of_an_exact_model_are_found(situation):
    """Within what friction, several contacts and other plants make of them."""
    found = static_estimates(STATICS[situation], IDEAL, 40, 3)
    far = found.location > 0.5
    error = np.abs(found.estimated_force - found.force)[far]
    assert len(error) > 5
    assert np.median(error) < 0.2 * np.median(found.force[far])
    assert (~(found.force > found.bounds[:, 2]) | (found.location < 0.3)).mean() > 0.9
    assert np.isfinite(found.degrees).any() == (situation == "in space")


@pytest.mark.slow
def test_a_finger_on_a_peg_is_seen_at_rest_and_after_steps():
    found = peg_estimates(IDEAL, 1, 1)
    assert tuple(found) == PEG
    for each in found.values():
        assert len(each.force) > 3
        assert np.nanmedian(np.abs(each.estimated_force - each.force)) < 0.3 * np.median(each.force)
