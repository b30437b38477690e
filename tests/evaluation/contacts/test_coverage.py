"""How often what is stated of a contact is true: the rows, the contacts, and the study on few of them."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.evaluation.contacts.coverage import (
    ENOUGH,
    FIGURE,
    TABLE,
    CoverageRow,
    conditions,
    coverage_row,
    coverage_rows,
    estimated,
    in_doubt,
    main,
    several_contacts,
)
from soft_gripper.evaluation.contacts.friction_cone import rubbing_contacts
from soft_gripper.files.csv_table import read_csv
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.fingers.statics import relaxed_law
from soft_gripper.sensors.sensor_layout import SensorLayout


def stated(contacts, low, high, places):
    """A posterior of two contacts that are detected."""
    force, nan = np.stack([low, high], axis=-1), np.full((2, 2), np.nan)
    quantiles, bounds = np.stack([low, low, high], axis=-1), np.stack([high, high, 2 * high], axis=-1)
    one = np.ones(2)
    return ContactPosterior(one, 2 * one, quantiles, force, bounds, places, nan, nan, 0 * one)


def test_a_row_has_the_share_of_which_is_stated_what_is_true():
    contacts = rubbing_contacts(2, 0.45, 0.0, 3, (0.5, 0.9))
    assert len(contacts.force) == 2
    force, place = np.abs(contacts.force), contacts.arc_length
    layout = SensorLayout(contacts.finger, 2)
    found = stated(contacts, 0.5 * force, np.array([2.0, 0.9]) * force, np.stack([place - 1e-3, place + 1e-3], axis=-1))
    row = coverage_row("by hand", conditions()[0], layout, 0.5, contacts, found)
    assert (row.number, row.detected_percent, row.explained_percent) == (2, 100, 100)
    assert (row.interval_percent, row.set_percent, row.bound_percent, row.bound_beyond_percent) == (50, 50, 50, 50)
    assert (row.bound_several_percent, row.place_percent) == (100, 100)
    assert (row.width, row.bound, row.bound_several) == pytest.approx((0.95, 1.45, 2.9))
    nothing = found._replace(probability=np.zeros(2), force_set=np.full((2, 2), np.nan))
    row = coverage_row("by hand", conditions()[0], layout, 0.5, contacts, nothing)
    assert (row.detected_percent, row.explained_percent) == (0, 0)
    assert np.isnan([row.interval_percent, row.bound_percent, row.place_percent, row.width]).all()


def test_several_contacts_are_in_balance_and_their_bound_covers_the_sum():
    """On one side beyond 0.3 of the length, where one force does not cover it."""
    for kind, contacts in several_contacts(30, 2):
        finger = contacts.finger
        assert len(contacts.force) > 10
        assert (contacts.arc_length > 0.3 * finger.length).all()
        known = finger.pressure_torque(contacts.pressure) + gravity_torque(
            finger, contacts.q, contacts.gravity[:, None]
        )
        elastic = relaxed_law(finger).inverse()(known + contacts.torque)
        np.testing.assert_allclose(contacts.q, elastic, atol=1e-8)
        layout = SensorLayout(finger, 4)
        found = estimated(layout, contacts, conditions()[0], 1)
        row = coverage_row(kind, conditions()[0], layout, float("nan"), contacts, found)
        assert row.bound_several_percent == 100
        assert row.explained_percent < 80
        assert row.bound_several < 2.5


def test_errors_as_assumed_differ_from_none():
    contacts = rubbing_contacts(3, 0.45, 0.0, 3)
    layout = SensorLayout(contacts.finger, 4)
    ideal, assumed = (next(each for each in conditions() if name in each.name) for name in ("ideal", "assumed"))
    exact, erring = (estimated(layout, contacts, condition, 1) for condition in (ideal, assumed))
    again = estimated(layout, contacts, replace(assumed, as_assumed=False, noise=0.0), 1)
    assert not np.allclose(exact.force_interval, erring.force_interval, rtol=1e-4)
    np.testing.assert_array_equal(exact.force_interval, again.force_interval)


@pytest.mark.slow
def test_intervals_cover_the_truth_in_each_third_of_the_length():
    """Of 150 contacts of every kind, as often as the bar demands, give or take what so few can show."""
    rows = [row for row in coverage_rows(150, 7, 0, lambda line: None) if row.beyond == row.beyond]
    for condition in conditions():
        for thirds in ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (0.7, 0.8, 0.9)):
            part = [row for row in rows if row.condition == condition.name and row.beyond in thirds]
            numbers = np.array([row.number for row in part])
            for field in ("interval", "set", "bound", "place"):
                shares = np.array([getattr(row, f"{field}_percent") for row in part])
                known = np.isfinite(shares)
                assert shares[known] @ numbers[known] / numbers[known].sum() > ENOUGH, (condition.name, thirds, field)


@pytest.mark.slow
def test_the_study_writes_its_table_and_figure(tmp_path, capsys):
    main(20, 3, 20, str(tmp_path))
    rows = read_csv(tmp_path / TABLE, CoverageRow)
    assert {row.contacts for row in rows} > {"simulated", "two contacts"}
    assert (tmp_path / f"{FIGURE}.png").stat().st_size > 10_000
    assert "least coverage" in capsys.readouterr().out


def test_a_share_that_may_be_low_by_chance_is_in_doubt():
    contacts = rubbing_contacts(2, 0.45, 0.0, 3, (0.5, 0.9))
    layout, force, place = SensorLayout(contacts.finger, 2), np.abs(contacts.force), contacts.arc_length
    found = stated(contacts, 0.5 * force, 2 * force, np.stack([place - 1e-3, place + 1e-3], axis=-1))
    row = replace(coverage_row("by hand", conditions()[0], layout, 0.5, contacts, found), number=120)
    shares = "interval", "set", "bound", "place"
    assert not in_doubt(row, shares, 1000)
    assert in_doubt(replace(row, set_percent=93.9), shares, 1000)
    assert not in_doubt(replace(row, set_percent=93.9), shares, 0)
    assert in_doubt(replace(row, detected_percent=50.0), shares, 1000), "60 are detected, and 500 would be"
    assert not in_doubt(replace(row, detected_percent=5.0), shares, 1000), "50 would be too few as well"
