"""Rows of the study of robustness, and the plants that it simulates."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_station
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.kinematics import in_space
from soft_gripper.runs.scores.readings import read_again
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.estimator_setup import EstimatorSetup
from studies.robustness import rows as module
from studies.robustness.plants import FINE, PLANTS, RUBBER, rubber_moment
from studies.robustness.rows import (
    Errors,
    band_coverage,
    estimator_errors,
    joined,
    nominal_name,
    plant_table,
    pose_statistics,
    robustness_table,
)


def errors_at(noise):
    return EstimatorSetup(2, noise).errors


def test_noise_is_a_multiple_of_the_preset() -> None:
    one, four = errors_at(1.0), errors_at(4.0)
    assert errors_at(0.0) is None
    assert one is not None
    assert four is not None
    for name in ("noise", "hysteresis", "gain_error", "drift"):
        assert getattr(one, name) > 0
        assert getattr(four, name) == pytest.approx(4 * getattr(one, name))
    assert four.creep_time == one.creep_time


def test_a_nominal_model_is_wrong_by_its_size(shipped_finger) -> None:
    nominal = EstimatorSetup(2, stiffness=-0.1).nominal_finger(shipped_finger)
    assert nominal.base.youngs_modulus == pytest.approx(0.9 * shipped_finger.base.youngs_modulus)
    assert EstimatorSetup(2, pressure=0.01).nominal_finger(shipped_finger) == shipped_finger


NAMES = ("arcs", "gaussian")
EXACT, SOFT = (0.0, 0.0), (-0.1, 0.01)  # errors of modulus and pressure
TWO_NOMINALS = (EXACT, SOFT)


def test_a_row_for_every_nominal_model_number_of_sensors_and_estimator(held) -> None:
    rows = robustness_table("free", [held], 0.0, 5, NAMES, TWO_NOMINALS)
    expected = [
        (nominal_name(*b), n, name) for b in TWO_NOMINALS for n in (1, 2, 3, 4) for name in ("arcs", "gaussian")
    ]
    assert [(row.nominal, row.sections, row.estimator) for row in rows] == expected
    assert {(row.scenario, row.noise, row.seeds) for row in rows} == {("free", 0.0, 5)}
    assert all(row.mean_mm <= row.p95_mm <= row.worst_mm for row in rows)
    assert all(np.isnan(row.coverage) == (row.estimator == "arcs") for row in rows)


def row_of(held, nominal: tuple[float, float], estimator: str, sections: int = 1):
    """With ideal sensors."""
    rows = robustness_table("free", [held], 0.0, 1, NAMES, [nominal])
    (row,) = (row for row in rows if (row.estimator, row.sections) == (estimator, sections))
    return row


def test_a_pressure_that_is_read_wrong_misleads_an_estimator_that_uses_it_and_no_other(held) -> None:
    """By the share of the bend that `gaussian` believes in; sensors this good leave little of it with four."""
    exact, wrong = (row_of(held, (0.0, share), "gaussian") for share in (0.0, 0.2))
    assert wrong.mean_mm > 10 * exact.mean_mm
    assert row_of(held, (0.0, 0.2), "arcs").mean_mm == row_of(held, EXACT, "arcs").mean_mm


def test_an_estimator_expects_its_nominal_models_to_be_as_wrong_as_they_are(held, monkeypatch) -> None:
    """Of stiffness and pressure together; beside the half percent of a finger that is known."""
    expected = []
    monkeypatch.setattr(
        module, "estimator_errors", lambda *given: expected.append(given[2]) or estimator_errors(*given)
    )
    row_of(held, (-0.06, 0.08), "gaussian")
    found = np.array([uncertainty.bend_per_pressure for uncertainty in expected])
    np.testing.assert_allclose(found, np.hypot(0.1, 0.005))


def test_numbers_of_a_row_are_those_of_all_fingers_joined(held, monkeypatch) -> None:
    """Of two fingers alike: mean, 95th percentile and worst of the pose, and the mean of the tip, in mm."""
    errors = Errors(1e-3 * np.array([0, 0, 0, 0, 10.0]), 1e-3 * np.array([2, 2, 2, 2, 12.0]), np.array([True, False]))
    monkeypatch.setattr(module, "estimator_errors", lambda *_: errors)
    row = plant_table(FINE, "free_bending", [held, held], 1, ["gaussian"])[0]
    found = row.mean_mm, row.p95_mm, row.worst_mm, row.tip_mm, row.coverage
    assert found == pytest.approx((2.0, 10.0, 10.0, 4.0, 0.5))


def points(finger, q):
    return in_space(ShapeEstimate(q).points(finger))


@pytest.mark.parametrize(("scale", "share"), [(1.0, 0.95), (0.5, 0.67), (2.0, 1.0)])
def test_bands_cover_as_they_say(shipped_finger, bent, scale, share) -> None:
    """Of normal errors with a known covariance; of half that, 0.67, and of twice, nearly all."""
    rng, spread = np.random.default_rng(5), 1e-3 * bent(12, 12)
    q = np.full((4000, 12), 0.1)
    truth = points(shipped_finger, q + rng.standard_normal(q.shape) @ spread.T)
    covariance = np.broadcast_to(scale**2 * spread @ spread.T, (4000, 12, 12))
    found = band_coverage(shipped_finger, ShapeEstimate(q, covariance), truth)
    assert found.shape == (4000, 12)
    assert found.mean() == pytest.approx(share, abs=0.015)


def test_numbers_of_a_row() -> None:
    parts = [
        Errors(1e-3 * np.arange(51.0), np.zeros(51), np.array([True])),
        Errors(1e-3 * np.arange(51.0, 101), np.zeros(50), np.array([True, True, False])),
    ]
    assert pose_statistics(joined(parts)) == pytest.approx((50.0, 95.0, 100.0, 0.75))
    skewed = pose_statistics(Errors(1e-3 * np.array([0, 0, 0, 0, 10.0]), np.zeros(5), np.array([True])))
    assert skewed == pytest.approx((2.0, 8.0, 10.0, 1.0))
    nothing = pose_statistics(Errors(np.ones(1), np.ones(1), np.zeros(0, bool)))
    assert np.isnan(nothing[-1])


@pytest.mark.parametrize("name", SHAPE_FUNCTIONS)
def test_estimators_are_compared_with_the_recording(held, name) -> None:
    """Four ideal sensors per side know a finger that bends freely, at every held sample and seed.

    Shortly after a step `recursive` takes what the finger still moves for a load, whose modes follow its posture.
    """
    errors = estimator_errors(name, SensorLayout(held.simulated, 4), Uncertainty(), held, held.readings(4, None, 2))
    assert errors.pose.shape == errors.tip.shape == (2 * len(held.samples),)
    assert errors.pose.max() < (1.5e-3 if name == "recursive" else 5e-4)
    assert (errors.covered.size > 0) == (name not in ("arcs", "constant_curvature", "spline"))


def test_a_filter_goes_through_all_samples_whichever_are_wanted(held) -> None:
    layout, rows = SensorLayout(held.simulated, 2), held.samples
    function = RecursiveShape(layout, Uncertainty(), held.period)
    pressure, gravity = np.tile(held.pressure[:, None], (1, 2)), np.tile(held.gravity[:, None], (1, 2, 1))
    given = held.readings(2, None, 2), layout.finger.pressure_torque(pressure), gravity
    whole, some = function(*given), function.at(rows, *given)
    np.testing.assert_array_equal(some.q, whole.q[rows])
    np.testing.assert_array_equal(some.covariance, whole.covariance[rows])


def test_rubber_is_as_stiff_as_believed_at_60_degrees_and_softer_beyond(shipped_finger) -> None:
    rubber = RUBBER.finger(shipped_finger)
    nominal = [np.full(12, np.radians(bend) / 12) for bend in (60, 120, -30)]
    simulated = [np.repeat(q, 2) / 2 for q in nominal]
    linear, curved = (
        [float(finger.elastic_torque(q)[len(q) // 2]) for q in angles]
        for finger, angles in ((shipped_finger, nominal), (rubber, simulated))
    )
    assert curved[0] == pytest.approx(linear[0], rel=0.01)
    assert curved[1] < 0.95 * linear[1]
    assert curved[2] < 1.1 * linear[2] < 0


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_stations_have_these_fingers(tmp_path, shipped_finger, plant) -> None:
    """Of a scenario whose peg a thicker finger would overlap."""
    station = make_station(plant.scenario("obstructed_outside", tmp_path))
    assert {finger.finger.segments for finger in station.fingers} == {plant.finger(shipped_finger).segments}
    assert station.scenario.pressure.steps["all"][-1] == pytest.approx(-50e3 * plant.pressure)
    assert station.scenario.plant_config.time_step == plant.time_step


def test_a_solid_strip_meets_the_series(shipped_finger) -> None:
    """Without layer and chamber the even terms cancel: M = E I k (1 + (4/3) k^2 <x^4> / <x^2>)."""
    solid = dict.fromkeys(("chamber_width", "chamber_thickness", "layer_thickness", "layer_modulus"), 0.0)
    section = replace(shipped_finger.base, **solid)
    curvature, h = np.array([2.0, 6.0]), section.thickness
    expected = section.bending_stiffness * curvature * (1 + 4 / 3 * curvature**2 * (h**4 / 80) / (h**2 / 12))
    np.testing.assert_allclose(rubber_moment(section, curvature), expected, rtol=5e-5)


def test_true_points_are_those_of_the_samples_that_are_read(held) -> None:
    tips = held.recording.samples(f"{held.finger.name}.true_tip_position")[held.samples]
    np.testing.assert_allclose(held.points(np.array([held.simulated.length]))[:, 0], tips, rtol=0, atol=1e-15)


def test_without_errors_all_seeds_read_the_truth(held) -> None:
    truth = read_again(held.station, held.recording, held.finger, 3)
    readings = held.readings(3, None, 2)
    assert readings.shape == (len(truth.readings), 2, 6)
    np.testing.assert_allclose(readings[:, 0], truth.readings, atol=1e-15)
    np.testing.assert_array_equal(readings[:, 0], readings[:, 1])
    np.testing.assert_array_equal(held.pressure, truth.pressure)
    np.testing.assert_array_equal(held.gravity, truth.gravity)


def test_seeds_err_differently_and_every_time_alike(held) -> None:
    errors, truth = StrainErrors(noise=1e-3), held.readings(2, None, 3)
    read = held.readings(2, errors, 3)
    np.testing.assert_array_equal(read, held.readings(2, errors, 3))
    assert (read - truth).std(axis=0) == pytest.approx(1e-3, rel=0.4)
    assert np.abs(read[:, 0] - read[:, 1]).min() > 0
