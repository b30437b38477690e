"""Compares point contact with contact over the true surface in a grasp: speed, errors and creep.

Errors are differences with the same step at the end of the scenario: of the tip of
the left finger and of the contact force on it; creep is the speed of the object, over the last second. Speed is that of
the whole station with all its signals, and with `record.truth: forces`, each with no signal of the recording read and
with all of them; CPU time, the least of several alternating runs.
"""

import argparse
from functools import partial

import numpy as np

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.scenario.scenario_file import load_scenario
from studies.speed.timed_run import cpu_time, read_all

SCENARIOS = {
    "box_grasp": ["pressure.steps.all=[50.0e3, 100.0e3, 150.0e3, 150.0e3]"],
    "irregular_grasp": ["pressure.steps.all=[75.0e3, 150.0e3]"],
}
ROUNDS = 3


def run(options: argparse.Namespace) -> None:
    """Prints a table for each scenario."""
    for name in options.scenarios or SCENARIOS:
        print(f"\n{name:<12} faster  all read  forces  all read  tip [mm]  force [%]  creep [mm/s]")
        kinds = {"surface": [], **{f"{n} points": ["contact=points", f"contact_points={n}"] for n in (2, 4, 8)}}
        stations = {
            kind: [_station(name, [*kind_changes, *truth]) for truth in ([], ["record.truth=forces"])]
            for kind, kind_changes in kinds.items()
        }
        seconds = {kind: np.full((2, 2), np.inf) for kind in stations}  # by the truth, with nothing and with all read
        recordings: dict[str, Recording] = {}
        for _ in range(ROUNDS):
            for kind, pair in stations.items():
                for i, station in enumerate(pair):
                    made: list[Recording] = []
                    seconds_run = cpu_time(partial(made.extend, map(run_station, [station])))
                    read_time = cpu_time(partial(read_all, made[0]))
                    seconds[kind][i] = np.minimum(seconds[kind][i], [seconds_run, seconds_run + read_time])
                    recordings.setdefault(kind, made[0])
        reference = recordings["surface"]
        for kind, recording in recordings.items():
            speedups = " ".join(f"{gain:>8.2f}" for gain in (seconds["surface"] / seconds[kind]).ravel())
            tip, force = (
                _last(recording, signal) - _last(reference, signal)
                for signal in ("true_tip_position", "true_contact_force")
            )
            relative = 100 * force.item() / _last(reference, "true_contact_force").item()
            row = f"{speedups} {1e3 * np.linalg.norm(tip):>9.3f} {relative:>10.2f}"
            print(f"{kind:<10} {row} {1e3 * _creep(recording, stations[kind][0]):>13.4f}", flush=True)


def _station(name: str, overrides: list[str]) -> Station:
    return make_private_station(load_scenario(name, [*SCENARIOS[name], *overrides]))


def _last(recording: Recording, signal: str) -> np.ndarray:
    return np.atleast_1d(recording[f"left_finger.{signal}"].values[-1])


def _creep(recording: Recording, station: Station) -> float:
    """Speed of the free object over the last second, m/s."""
    (name,) = (model.name for model in station.scenario.models if model.free)
    places = recording[f"{name}.pose"].values[:, 4:]
    return float(np.linalg.norm(places[-1] - places[-1 - round(1 / station.scenario.sensor.period)]))
