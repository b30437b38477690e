"""What is stated of forces, how often it is true, and the posterior that it follows from."""

import numpy as np
import pytest
from loaded_fingers import Push, in_balance

from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from studies.contacts.contact_coverage import (
    COLUMNS,
    coverage_row,
)
from studies.contacts.contacts import read_finger
from studies.contacts.estimates import Estimates, driving_torque
from studies.contacts.situations import PEG, STATICS, peg_estimates, read_pressed, static_estimates
from studies.contacts.statics import rubbing_contacts
from studies.estimator_setup import MODELS, NOMINAL, EstimatorSetup

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


ASSUMED = Uncertainty(reading=1.5e-3, bend_variation=0.0)


def dense(found, usual, largest):
    """Forces, (K), and the density of cells and logarithms of force at them, (C, K), of one sample."""
    forces = np.geomspace(largest / 1000, largest, 2001)
    fits = [values[0][:, None] for values in found.fits]
    force, std, misfit, spread = fits
    logs = -(misfit + ((forces - force) / std) ** 2 + spread + (forces / usual) ** 2) / 2
    density = found.cells.prior[:, None] * np.exp(logs - logs.max())
    return forces, density / density.sum()


def check(density, forces, across, reported, std, interval):
    """The force is the most probable one; the deviation, of forces times their part across, is about it."""
    cell, number = np.unravel_index(density.argmax(), density.shape)
    assert reported == pytest.approx(across[cell] * forces[number], rel=0.1), "the place is within the cell"
    distance = across[:, None] * forces - reported
    assert std == pytest.approx(np.sqrt((density * distance**2).sum()), rel=0.1)
    assert interval[0] <= forces[number] * 1.001
    assert interval[2] >= forces[number] * 0.999
    shares = np.cumsum(density.sum(axis=0))
    least, median, most = np.interp(interval, forces, shares)
    assert median == pytest.approx(0.5, abs=0.02)
    assert 0.94 < most - least < 0.99


@pytest.mark.parametrize("sections", [2, 4])
@pytest.mark.parametrize(("place", "force"), [(0.25, 0.8), (0.45, -0.5), (0.55, 0.7), (0.8, -0.4), (1.0, 0.6)])
def test_in_the_plane(shipped_finger, sections, place, force):
    layout, s = SensorLayout(shipped_finger, sections), place * shipped_finger.length
    shape = ContactShape(layout, ASSUMED)
    q = in_balance(shipped_finger, 60e3, 9.81, [Push(s, force, 0.3 * abs(force))])
    readings, driving = layout.response.reading(extension_ratios(layout, q)), shipped_finger.pressure_torque(60e3)
    given = readings[None], driving[None], np.array([[0.0, 0.0, 9.81]])
    contact, known = shape(*given).contact, shape.posterior(*given)
    assert contact.force != 0
    found = shape._explain(shape._gaussian(*given).q, *given)[0].cell_fits
    forces, density = dense(found, shape.contact.mechanics.usual_force, ASSUMED.largest_force)
    check(density, forces, found.cells.side, contact.force[0], contact.force_std[0], known.force_interval[0])


FRICTION, FAR = 0.6, 0.4  # coefficient; of the length, beyond which contacts count


@pytest.fixture(scope="module")
def contacts():
    """With any friction up to the cone, on both sides."""
    return rubbing_contacts(200, 31, FRICTION, places=(0.3, 1.0))


@pytest.mark.parametrize(
    ("sections", "borders", "noise", "model", "median", "tenth"),
    [
        (2, [1 / 3], 0.0, MODELS[0], 0.01, 0.06),
        (4, None, 0.0, MODELS[0], 0.004, 0.02),
        (4, None, 1.0, MODELS[0], 0.05, 0.2),
        (4, None, 1.0, NOMINAL, 0.06, 0.2),
    ],
)
def test_its_errors_are_small_and_its_interval_is_true(contacts, sections, borders, noise, model, median, tenth):
    """Median and 90th percentile of its relative error; the normal force errs more, and its interval is wider."""
    setup, transverse = EstimatorSetup(sections, noise, model), contacts.transverse_force
    layout = SensorLayout(read_finger(), sections, borders=borders)
    shape = ContactShape(layout, setup.uncertainty)
    readings = read_pressed(layout, contacts.q, setup.errors, np.random.default_rng(1))
    given = readings, driving_torque(layout.finger, layout.deformations, contacts.pressure), contacts.gravity
    contact, known = shape(*given).contact, shape.posterior(*given)
    counted = (contacts.arc_length > FAR * layout.finger.length) & (known.probability > DETECTION_PROBABILITY)
    assert counted.sum() > 140
    error = np.abs(contact.transverse_force / transverse - 1)[counted]
    of_normal = np.abs(np.abs(contact.force) / contacts.normal_force - 1)[counted]
    assert np.median(error) < min(median, 0.8 * np.median(of_normal))
    assert np.percentile(error, 90) < tenth
    least, _, most = known.transverse_force_interval[counted].T
    true = (least <= transverse[counted]) & (transverse[counted] <= most)
    assert true.mean() > 0.93
    normal_width = np.ptp(known.force_interval[counted][:, [0, 2]], axis=-1) / contacts.normal_force[counted]
    assert np.median((most - least) / transverse[counted]) < 0.75 * np.median(normal_width)
    z = (contact.transverse_force - transverse)[counted] / contact.transverse_force_std[counted]
    assert 0.2 < np.sqrt((z**2).mean()) < 1.2
