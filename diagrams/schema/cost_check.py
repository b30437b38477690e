"""How long a run would take, before it is begun: what cannot end is refused."""

from pathlib import Path

from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.diagrams.schema.scenario import Scenario

MOST_STEPS = 10_000_000  # of the plant: about an hour with one finger
MOST_SAMPLES = 1_000_000  # of every signal: gigabytes of logs


def check_cost(where: Path | str, scenario: Scenario) -> None:
    """Estimates the steps and the samples of a run, from its length.

    Raises:
        InputError: if they would be more than anybody waits for; it names the estimate.
    """
    plant, solver = scenario.plant_config, scenario.simulator_config
    discrete = plant.time_step > 0
    field, step = (
        ("plant_config.time_step", plant.time_step)
        if discrete
        else ("simulator_config.max_step_size", solver.max_step_size)
    )
    duration = scenario.duration
    for name, period, most, what in (
        (field, step, MOST_STEPS, "steps"),
        ("sensor.period", scenario.sensor.period, MOST_SAMPLES, "samples"),
    ):
        number = duration / period
        expected = f"{duration:g} s would be {number:.2g} {what}, of at most {most:.0e}: give more, or a shorter run"
        require(number <= most, where, name, period, expected)
