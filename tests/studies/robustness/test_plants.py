"""Other plants: their files, rubber by closed forms, and held fingers: samples, readings, and points along them."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_station
from soft_gripper.runs.scores.readings import read_again
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.robustness.plants import FINE, PLANTS, RUBBER, TAPERED, rubber_moment


def test_fingers_differ_as_they_say(shipped_finger) -> None:
    fine, tapered, rubber = (plant.finger(shipped_finger) for plant in (FINE, TAPERED, RUBBER))
    assert (fine.segments, fine.base, fine.elastic_law) == (24, shipped_finger.base, None)
    assert (tapered.segments, tapered.base.thickness, tapered.tip.thickness) == (12, 0.035, 0.015)
    assert rubber.segments == 24
    assert rubber.elastic_law is not None


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
