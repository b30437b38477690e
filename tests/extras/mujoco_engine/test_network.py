"""A network of blocks around Drake's own plant does what Drake's simulator does with the station."""

import numpy as np
import pytest
from drake_plants import DrakePlants

from soft_gripper.diagrams.recording import make_recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.mujoco_engine.lockstep import simulate_network
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.scenario.scenario_file import changed_scenario

REALISTIC = {"sensor.errors.preset": "realistic", "sensor.seed": 3, "record.truth": "forces"}
CASES = {
    "tip_distance_steps": {
        **{"control.set_points": [0.06, 0.03], "control.hold": 1.0, "estimator.type": "gaussian"},
        "sensor.period": 0.02,  # longer than a step of the plant
    },
    "three_chambers": {
        **{"pressure.steps": {"all": [60e3, 20e3]}, "pressure.settle": 0.3, "pressure.hold_samples": 10},
        **{"pressure.leaks": {"all": 0.2}, "pressure.leak_time": 0.12},  # between two samples
    },
    "tendon_grasp": {"tendons.steps": {"all": [2.0, 4.0]}, "pressure.settle": 0.3, "pressure.hold_samples": 10},
    "pick_and_place_box": {"task.time_limit": 2.5, "plant_config.time_step": 0.01},
    "pick_and_place_delicate": {"task.time_limit": 0.4, "plant_config.time_step": 0.01},
}


@pytest.mark.parametrize("name", CASES)
def test_every_signal_is_that_of_the_simulator(name):
    scenario = changed_scenario(name, CASES[name] | REALISTIC)
    station = make_private_station(scenario, composed=False)
    network = Network([station], DrakePlants(station), station.logs)
    logs, (length,), failed = simulate_network(station, network)
    assert not failed
    time = np.arange(length) * scenario.sensor.period
    found = make_recording(station.logs.labels, station.logs.make_samples(time, logs.samples_of(0, length))).data
    expected = simulate(scenario).data
    assert found["time"].values == pytest.approx(expected["time"].values)
    assert set(found) == set(expected)
    for signal, values in expected.items():
        np.testing.assert_allclose(found[signal].values, values.values, rtol=1e-9, atol=1e-9, err_msg=str(signal))
