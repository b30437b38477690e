"""How long a run would take, before it is begun: what cannot end is refused."""

from pathlib import Path

from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.diagrams.schema.scenario import Scenario

MOST_STEPS = 2_000_000  # of the plant: a quarter of an hour with one finger
MOST_SAMPLES = 500_000  # of every signal: gigabytes of logs
MOST_TIME = 86_400.0  # s, of a run that is held back to some part of real time
FINEST = 1e-9  # accuracy: below, error control takes steps without end


def check_cost(where: Path | str, scenario: Scenario) -> None:
    """Estimates the steps, the samples and the time of a run, from its length.

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
    rate = solver.target_realtime_rate
    expected = f"give 0, which is as fast as it can be, or a part of real time that takes {duration:g} s a day at most"
    fine = rate == 0 or (rate > 0 and duration / rate <= MOST_TIME)
    require(fine, where, "simulator_config.target_realtime_rate", rate, expected)
    expected = f"give {FINEST:g} or more"
    require(solver.accuracy >= FINEST, where, "simulator_config.accuracy", solver.accuracy, expected)
