"""Parts of the engine: a network of blocks, the choice of its step, warnings."""

import numpy as np
import pytest
from drake_plants import DrakePlants
from here_executor import HereExecutor

from soft_gripper.diagrams.recording import make_recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.mujoco_engine import engine
from soft_gripper.extras.mujoco_engine.engine import _net_forces
from soft_gripper.extras.mujoco_engine.library import load_mujoco
from soft_gripper.extras.mujoco_engine.lockstep import simulate_network
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.extras.sweeps.measured_runs import engine_step_of
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.truth.contact import COLUMNS

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


ENGINE = {"engine": "mujoco"}


@pytest.fixture
def suited(monkeypatch):
    """The scenarios for which a step was chosen."""
    asked = []

    def suited_step(scenario):
        asked.append(scenario)
        return 0.0025

    monkeypatch.setattr(engine, "suited_step", suited_step)
    return asked


def test_the_step_suits_the_scenario_with_what_all_runs_change(suited):
    fixed = ENGINE | {"sensor.period": 0.02}
    assert engine_step_of("free_bending", fixed, HereExecutor()) == {"engine_step": 0.0025}
    assert [scenario.sensor.period for scenario in suited] == [0.02]


@pytest.mark.parametrize("fixed", [{}, ENGINE | {"engine_step": 0.001}])
def test_no_step_is_chosen_in_drake_or_if_one_is_given(suited, fixed):
    assert engine_step_of("free_bending", fixed, HereExecutor()) == {}
    assert not suited


def test_points_of_a_finger_that_oppose_each_other_count_together():
    """Two points, of which one is listed from the side of the object: 3 N across in all, and 5 N against 5 N along."""
    rows = np.zeros((2, COLUMNS))
    rows[:, 3], rows[:, 10:13] = [1, -1], [[1, 5, 0], [-2, 5, 0]]
    assert _net_forces([rows, rows], 2).tolist() == [3, 0]


mujoco = pytest.importorskip("mujoco")

BALL = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'


def test_a_state_that_diverges_leaves_no_file(tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    load_mujoco()
    model = mujoco.MjModel.from_xml_string(BALL)
    data = mujoco.MjData(model)
    data.qvel[:] = np.nan
    mujoco.mj_step(model, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQVEL].number == 1
    mujoco.get_mju_user_warning()("memory is full")
    assert caplog.messages == ["memory is full"]
    assert list(tmp_path.iterdir()) == []
