"""Simulates grasps of objects of four shapes for the benchmark: mean readings at every pressure, in `data`.

Two fingers close on an object, and press harder twice (`probing_grasp`, see `random_objects`). A row has the
mean readings at the end of every pressure, by realistic sensors drawn anew for every grasp.

`python -m studies benchmark-data` writes the files again, to the last digit.
"""

from pathlib import Path

import numpy as np
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import results
from soft_gripper.files.row_table import write_rows
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.runs.scores.readings import read_again
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.sensor_presets import strain_errors
from studies.benchmark.random_objects import (
    MEAN_SAMPLES,
    SENSOR_STREAM,
    SETS,
    SHAPES,
    disturb_readings,
    draw,
    replace_object,
)

SCENARIO, SECTIONS = "probing_grasp", 2
PRESSURES = (75e3, 112.5e3, 150e3)  # Pa, as in the scenario
FINGERS = ("left", "right")
READINGS = 4  # readings of a finger: two sections on the inner and on the outer side
FOLDER = Path(__file__).parent / "data"
FILES = {"grasps_train.csv": ("train", 60), "grasps_test.csv": ("test", 50)}  # numbers of every shape
_SEED = 21


def columns() -> list[str]:
    """Names of the readings, in their order: (pressures, fingers, readings)."""
    levels, readings = range(len(PRESSURES)), range(READINGS)
    return [f"{finger}_{reading}_at_{level}" for level in levels for finger in FINGERS for reading in readings]


def readings(set: str, number: int, shape: str) -> Array:
    """Simulates a grasp and reads it, (columns,)."""
    scenario = replace_object(load_scenario(SCENARIO), shape, draw(_SEED, set, number, shape))
    station = make_private_station(scenario)
    recording = run_station(station)
    rng = np.random.default_rng([_SEED, SETS.index(set), number, *shape.encode(), SENSOR_STREAM])
    errors = strain_errors(scenario.sensor)
    assert errors is not None
    means = []
    for finger in station.fingers:
        sensors = disturb_readings(read_again(station, recording, finger, SECTIONS), errors, rng)[0]
        values = held_samples(scenario, recording, sensors.readings[sensors.numbers])
        means.append(values[:, -MEAN_SAMPLES:].mean(axis=1))
    return np.stack(means, axis=1).ravel()


def write_samples() -> None:
    """Simulates the grasps and writes the files."""
    for file, (set, count) in FILES.items():
        keys = [(set, number, shape) for shape in SHAPES for number in range(count)]
        with tqdm(total=len(keys), desc=file, unit="grasp") as bar, open_executor() as executor:
            means_by_grasp = results(executor, readings, {key: key for key in keys}, lambda _: bar.update())
        rows = ([shape, *(f"{value:.5g}" for value in values)] for (_, _, shape), values in means_by_grasp.items())
        write_rows(FOLDER / file, ["shape", *columns()], rows)
