"""Runs that differ in values alone are stepped together in MuJoCo, and each does what it does alone."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from soft_gripper.diagrams import station as stations
from soft_gripper.diagrams.simulation import run_many
from soft_gripper.extras.mujoco_engine import engine
from soft_gripper.scenario.scenario_file import changed_scenario

STEPS = {"engine": "mujoco", "engine_step": 0.005}
SHORT = STEPS | {"pressure.steps": {"all": [60e3, 120e3]}, "pressure.settle": 0.1, "pressure.hold_samples": 5}
CLOSED = STEPS | {"control.set_points": [0.05, 0.03], "control.hold": 0.1}
MODULUS, LENGTH = "models.gripper.fingers.all.youngs_modulus", "models.gripper.fingers.all.length"
VALUES = {
    "pressures": ("box_grasp", SHORT, [{"pressure.steps": {"all": [60e3, last]}} for last in (90e3, 140e3)]),
    "fingers": ("box_grasp", SHORT, [{LENGTH: 0.13}, {LENGTH: 0.14, MODULUS: 3e5}]),
    "leaks": ("box_grasp", SHORT | {"pressure.leak_time": 0.05}, [{"pressure.leaks": {"all": x}} for x in (0.1, 0.3)]),
    "sensor errors": (
        "tip_distance_steps",
        CLOSED,
        [{"sensor.errors.noise": noise, "sensor.seed": 2} for noise in (1e-4, 1e-3)],
    ),
    "set points and gains": (
        "tip_distance_steps",
        CLOSED,
        [{"control.set_points": [0.05, 0.04], "control.gains.kp": 3e5}, {"control.gains.ki": 2e6}],
    ),
}


@pytest.fixture
def networks(monkeypatch):
    """The number of environments of each network that is stepped."""
    counts, simulate = [], engine.simulate_network

    def counted(station, network):
        counts.append(network.count)
        return simulate(station, network)

    monkeypatch.setattr(engine, "simulate_network", counted)
    return counts


@pytest.mark.parametrize("kind", VALUES)
def test_runs_with_other_values_are_stepped_together_as_alone(kind, networks):
    name, base, changes = VALUES[kind]
    scenarios = [changed_scenario(name, base | each) for each in changes]
    together = [run.recording for run in run_many(scenarios)]
    assert networks == [2]
    for scenario, recording in zip(scenarios, together, strict=True):
        ((_, alone),) = run_many([scenario])
        assert set(alone.data) == set(recording.data)
        for signal in alone.data:
            np.testing.assert_array_equal(recording.values(signal), alone.values(signal), err_msg=signal)
    last = [each.values("plant.state")[-1] for each in together]
    assert not np.array_equal(*last)


def test_runs_of_other_structure_are_not_stepped_together(networks):
    changes = {"models.gripper.segments": 6}, {"models.gripper.segments": 8}, {"sensor.sections": 2}
    assert not any(
        isinstance(run, Exception) for run in run_many([changed_scenario("box_grasp", SHORT | c) for c in changes])
    )
    assert sorted(networks) == [1, 1, 1]


def test_a_plant_is_read_once_for_all_pressures(monkeypatch):
    read, add_plant = [], stations.add_plant
    monkeypatch.setattr(stations, "add_plant", lambda *arguments: read.append(0) or add_plant(*arguments))
    monkeypatch.setattr(engine, "_stations", type(engine._stations)())
    monkeypatch.setattr(engine, "_plant_sources", type(engine._plant_sources)())
    changes = [{"pressure.steps": {"all": [pressure]}} for pressure in (50e3, 60e3, 70e3)]
    runs = list(run_many([changed_scenario("box_grasp", SHORT | each) for each in changes]))
    assert len(read) == 1
    original, copied, _ = (run.station.plant for run in runs)
    assert original is not copied
    np.testing.assert_array_equal(original.GetDefaultPositions(), copied.GetDefaultPositions())
