"""What cannot end is refused before it begins, with the estimate."""

from dataclasses import replace

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names

ENDLESS = {
    "plant_config.time_step=5.0e-324": "time_step = 5e-324",
    "plant_config.time_step=1.0e-12": r"plant_config.time_step = 1e-12: 38 s would be 3.8e\+13 steps, of",
    "sensor.period=1.0e-12": r"sensor.period = 1e-12: .* samples, of at most 5e\+05",
    "pressure.settle=1.0e+15": r"plant_config.time_step = 0.01: .* s would be .*e\+18 steps",
    "pressure.hold_samples=4000000000": "steps, of at most",
    "simulator_config.target_realtime_rate=1.0e-6": "rate = 1e-06",
    "simulator_config.target_realtime_rate=-1": "rate = -1",
    "simulator_config.accuracy=1.0e-12": "accuracy = 1e-12",
}
CONTINUOUS = {"simulator_config.max_step_size=1.0e-12": r"simulator_config.max_step_size = 1e-12: 38 s would be"}


@pytest.mark.parametrize("override", ENDLESS)
def test_without_end(override: str) -> None:
    with pytest.raises(InputError, match=ENDLESS[override]):
        load_scenario("free_bending", [override])


@pytest.mark.parametrize("override", CONTINUOUS)
def test_without_end_if_the_plant_is_continuous(override: str) -> None:
    load_scenario("free_bending", [override])
    with refused("simulator_config.max_step_size", 1e-12):
        load_scenario("free_bending", [override, "plant_config.time_step=0"])


def test_a_task_counts_by_its_time_limit() -> None:
    with refused("plant_config.time_step", 0.005):
        load_scenario("pick_and_place_box", ["task.time_limit=1.0e+9"])


def test_more_models_than_can_be_read() -> None:
    scenario = load_scenario("box_grasp")
    box = scenario.models[-1]
    scenario.models += [replace(box, name=f"box{i}") for i in range(500)]
    with refused("models", 503):
        checked_scenario("many.yaml", scenario)


@pytest.mark.parametrize("name", scenario_names())
def test_shipped_scenarios_end(name: str) -> None:
    load_scenario(name, ["plant_config.time_step=0.00005"])
