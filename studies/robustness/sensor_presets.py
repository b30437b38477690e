"""Every preset of sensor errors in free bending: errors and external torque of `arcs`, coverage of `gaussian`.

In: the presets. Out: docs/sensor_presets.csv, which docs/sensors.md prints. Another number is a field of `PresetRow`
and of `finger_scores`. Fingers bend to 120 kPa and back with four sections per
side and an exact nominal model; sets of sensors and both fingers count together. False contacts are those of all
samples, the rest of held steps.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, cast

import numpy as np

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import Run, run_many
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.files.row_table import print_rows, write_csv
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import presets
from studies import ROOT
from studies.robustness.rows import BAND

TABLE = ROOT / "docs" / "sensor_presets.csv"
SEEDS = 10
UP = [0.0, 30e3, 60e3, 90e3, 120e3]  # Pa
CHANGES = {
    "sensor.sections": 4,
    "estimator.alongside": ["gaussian"],
    "estimator.contact_threshold": 2.5e-3,
    "pressure.steps": {"all": [*UP, *UP[-2::-1]]},
}


@dataclass(frozen=True)
class PresetRow:
    """Sensors with the errors of a preset."""

    preset: str
    pose_error_mm: Annotated[float, ".2f"]  # mean, of `arcs`
    tip_error_mm: Annotated[float, ".2f"]
    end_angle_covered_percent: Annotated[float, ".0f"]  # by 95 % bands of `gaussian`
    false_contact_percent: Annotated[float, ".0f"]  # of the time
    base_torque_mnm: Annotated[float, ".1f"]  # root mean square of the external torque at the base
    seeds: int


def finger_scores(station: Station, recording: Recording) -> Iterator[tuple[float, ...]]:
    """Errors, percentages and torque of each finger, in the order of PresetRow."""

    def held_values(signal: str) -> np.ndarray:
        return held_samples(station.scenario, recording, signal)

    for finger in (finger.name for finger in station.fingers):
        errors = (1e3 * float(held_values(f"{finger}.{name}").mean()) for name in ("pose_error", "fingertip_error"))
        estimated = held_values(f"{finger}.gaussian.estimated_joint_angles")
        true = held_values(f"{finger}.sampled_joint_angles")
        variance = held_values(f"{finger}.gaussian.joint_angle_covariance").sum(axis=(-2, -1))
        is_covered = np.abs((estimated - true).sum(axis=-1)) <= BAND * np.sqrt(variance)
        false = recording.values(f"{finger}.contact") != 0
        torque = 1e3 * float(np.sqrt((held_values(f"{finger}.external_torque")[..., 0] ** 2).mean()))
        yield *errors, 100 * float(is_covered.mean()), 100 * float(false.mean()), torque


def preset_row(preset: str) -> PresetRow:
    """Simulates a preset, and makes its table row."""
    changes = CHANGES | {"sensor.errors.preset": preset}
    scenarios = [changed_scenario("free_bending", changes | {"sensor.seed": seed}) for seed in range(SEEDS)]
    runs = cast(Iterator[Run], run_many(scenarios))
    scores = [score for run in runs for score in finger_scores(run.station, run.recording)]
    means = np.mean(scores, axis=0).tolist()
    return PresetRow(*[preset, *means, SEEDS])


def run(options: argparse.Namespace) -> None:
    """Writes and prints the table."""
    rows = [preset_row(preset) for preset in presets()]
    write_csv(TABLE, rows)
    print_rows(rows)
