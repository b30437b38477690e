"""The closing force in whole grasps, with realistic sensors: what theory/contact.md states."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.runs.scores.contact_forces import forces_at
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

GRASPS = ("box", "bottle", "conforming", "turned_box", "three_finger", "tendon", "probing")
SAMPLES = 80
LEAST = 0.05  # N


@pytest.mark.parametrize(("grasp", "sections"), [*((grasp, 2) for grasp in GRASPS), ("irregular", 3)])
def test_it_is_within_a_tenth_and_balances(grasp, sections):
    """While all fingers touch, but for the first quarter of that time."""
    scenario = load_scenario(f"{grasp}_grasp", [f"sensor.sections={sections}", "sensor.errors.preset=realistic"])
    station = make_private_station(scenario)
    recording = run_station(station)
    touched = [recording[f"{finger.name}.normal_force"].values.ravel() > LEAST for finger in station.fingers]
    held = np.flatnonzero(np.all(touched, axis=0))
    rows = held[np.linspace(len(held) // 4, len(held) - 1, SAMPLES).astype(int)]
    data = forces_at(station, recording, rows).data
    estimate = data["closing"].values
    assert np.isfinite(estimate).mean() > 0.95
    ratio = estimate / data["true_closing"].values
    assert np.nanmedian(ratio, axis=0) == pytest.approx(np.ones(len(station.fingers)), abs=0.06)
    assert (np.abs(ratio - 1) < 0.1)[np.isfinite(ratio)].mean() > 0.8
    if len(station.fingers) == 2:
        known = estimate[(estimate > LEAST).all(axis=1)]
        differences = np.ptp(known, axis=1) / known.mean(axis=1)
        assert np.median(differences) < 0.05
        assert np.percentile(differences, 90) < 0.11
