"""Recognizes the shape of a grasped object from the estimates of two fingers at three pressures.

Two fingers close on a sphere, a cylinder, a box or an uneven body of random place, turn, size, mass and friction, and
press harder twice (scenario `probing_grasp`). Of every shape 60 grasps train a discriminant, and 50 others test it;
each is read by eight sets of realistic sensors. It reaches 75 %: an upright cylinder and a box have one outline in the
plane in which the fingers bend and measure. With ideal sensors it is 86 %. Draws recognition.png.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import results
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.runs.scores.readings import external_torque_again, read_again
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.sensor_presets import strain_errors
from studies.benchmark.discriminant import NO_SHAPE, ObjectClassifier, train_object_classifier
from studies.benchmark.random_objects import (
    MEAN_SAMPLES,
    SENSOR_STREAM,
    SETS,
    SHAPES,
    disturb_readings,
    draw,
    replace_object,
)

SECTIONS = (2, 4)
GRASP_COUNTS = dict(zip(SETS, (60, 50), strict=True))  # of every shape
Key = tuple[str, int, str]  # one of SETS, number, shape


@dataclass(frozen=True)
class Probe:
    """Means at the end of every pressure step, for one number of sections and E sets of sensors."""

    angles: Array  # rad, (E, L, F, N)
    torques: Array  # N m, (E, L, F, N)


def run_grasp(key: Key, seed: int = 1, changes: Sequence[str] = ()) -> dict[int, Probe]:
    """Simulates a random grasp; its probes by numbers of sections."""
    set, number, shape = key
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode(), SENSOR_STREAM])
    scenario = load_scenario("probing_grasp", list(changes))
    station = make_private_station(replace_object(scenario, shape, draw(seed, set, number, shape)))
    recording = run_station(station)
    return {sections: probe(station, recording, sections, rng) for sections in SECTIONS}


def probe(station: Station, recording: Recording, sections: int, rng: np.random.Generator) -> Probe:
    """Estimates at the end of every pressure step with a number of sections, from one recording.

    If the scenario's sensors have errors, these are drawn from `rng` for every finger and SENSOR_DRAWS sets of sensors.
    """
    errors = strain_errors(station.scenario.sensor)
    angles: list[Array] = []
    torques: list[Array] = []
    for finger in station.fingers:
        readings_again = read_again(station, recording, finger, sections)
        sets = [readings_again] if errors is None else disturb_readings(readings_again, errors, rng)
        shapes = [readings.shape().q for readings in sets]
        loads = [external_torque_again(station, recording, finger, readings) for readings in sets]
        for target, values in ((angles, shapes), (torques, loads)):
            means = [
                held_samples(station.scenario, recording, value)[:, -MEAN_SAMPLES:].mean(axis=1) for value in values
            ]
            target.append(np.array(means))
    return Probe(np.stack(angles, axis=2), np.stack(torques, axis=2))


def train(grasps: Mapping[Key, Mapping[int, Probe]], sections: int) -> ObjectClassifier:
    """Trains the discriminant on the training grasps with a number of sections."""
    training = {key: probes[sections] for key, probes in grasps.items() if key[0] == SETS[0]}
    labels = [shape for (_, _, shape), probe in training.items() for _ in probe.angles]
    numbers = [i for i, probe in enumerate(training.values()) for _ in probe.angles]
    angles, torques = (
        np.concatenate([getattr(probe, name) for probe in training.values()]) for name in ("angles", "torques")
    )
    return train_object_classifier(labels, angles, torques, numbers)


def confusion(grasps: Mapping[Key, Mapping[int, Probe]], sections: int) -> Array:
    """Numbers of test grasps of each of SHAPES (rows) that are recognized as each, and as unknown (columns).

    Each set of sensors counts as a fraction of a grasp.
    """
    model, counts = train(grasps, sections), np.zeros((len(SHAPES), len(SHAPES) + 1))
    order = [model.answers.index(answer) for answer in (*SHAPES, NO_SHAPE)]
    for (set, _, shape), probes in grasps.items():
        if set == SETS[1]:
            probabilities = model.probabilities(probes[sections].angles, probes[sections].torques)[:, order]
            np.add.at(counts[list(SHAPES).index(shape)], probabilities.argmax(axis=-1), 1 / len(probabilities))
    return counts


WHITE_TEXT_SHARE = 0.55  # share of a shape's grasps, above which its number is white


def confusion_figure(matrices: Mapping[int, Array], number: int) -> Figure:
    """A confusion matrix (C, C + 1) of counts for each number of sections, of `number` grasps of each shape."""
    shapes = list(SHAPES)
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(4.4 * len(matrices), 3.9), layout="constrained")
        panels = figure.subplots(1, len(matrices), squeeze=False)[0]
        for axes, (sections, matrix) in zip(panels, matrices.items(), strict=True):
            _draw(axes, shapes, matrix, number)
            correct_share = np.trace(matrix) / (number * len(shapes))
            axes.set_title(f"{sections} sections: {100 * correct_share:.1f} % right")
        panels[0].set_ylabel("held")
    return figure


def _draw(axes: Axes, shapes: Sequence[str], matrix: Array, number: int) -> None:
    fractions = matrix / number
    axes.imshow(fractions, cmap="Blues", vmin=0, vmax=1)
    for (row, column), count in np.ndenumerate(matrix):
        color = "white" if fractions[row, column] > WHITE_TEXT_SHARE else "0.2" if count else "0.7"
        axes.text(column, row, f"{round(count, 1):g}", ha="center", va="center", color=color, fontsize=12)
    answers = [*shapes, NO_SHAPE]
    axes.set_xticks(range(len(answers)), answers)
    axes.set_yticks(range(len(shapes)), shapes)
    axes.set_xticks(np.arange(0.5, len(answers) - 1), minor=True)
    axes.set_yticks(np.arange(0.5, len(shapes) - 1), minor=True)
    axes.grid(which="minor", color="white", lw=2, alpha=1)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("recognized")


def run(options: argparse.Namespace) -> None:
    """Simulates the grasps, prints and draws the recognized shapes."""
    keys = [(set, number, shape) for set in SETS for number in range(GRASP_COUNTS[set]) for shape in SHAPES]
    with tqdm(total=len(keys), unit="grasp") as bar, open_executor(options.jobs, options.scheduler) as executor:
        grasps = results(executor, run_grasp, {key: (key,) for key in keys}, lambda _: bar.update())
    matrices = {sections: confusion(grasps, sections) for sections in SECTIONS}
    for sections, matrix in matrices.items():
        print(f"{sections} sections: {100 * np.trace(matrix) / matrix.sum():.1f} % right")
    options.out.mkdir(parents=True, exist_ok=True)
    save_figure(confusion_figure(matrices, GRASP_COUNTS[SETS[1]]), options.out / "recognition")
