"""The paper's three regimes of the grip control, at the largest step of a scenario: too quick, as shipped, too slow."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.evaluation.paper.scenario_run import evaluated_scenario
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import atomic_folder
from soft_gripper.runs.scores.steps import StepRow, step_figure, step_table
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import Scenario

REGIMES = {"under-damped": 3.0, "well damped (shipped)": 1.0, "over-damped": 0.3}  # of the shipped integral gain


@dataclass(frozen=True)
class RegimeRow:
    """One regime: its gains, kPa and m, and how the opening follows the step."""

    regime: str
    kp_kpa: float
    ki_kpa: float
    kd_kpa: float
    from_mm: float
    to_mm: float
    overshoot_percent: float
    crossings: int
    settling_s: float


def regime_scenarios(scenario: Scenario) -> dict[str, Scenario]:
    """Each regime as a scenario: the largest step between set points of `scenario`, which has at least two."""
    points, gains = scenario.control.set_points or [], scenario.control.gains
    largest = int(np.argmax(np.abs(np.diff(points))))
    step = replace(scenario.control, set_points=points[largest : largest + 2])
    return {
        regime: replace(scenario, control=replace(step, gains=replace(gains, ki=factor * gains.ki)))
        for regime, factor in REGIMES.items()
    }


def run_regimes(name: str, folder: Path) -> None:
    """Fills `folder`: scenario.yaml, regimes.csv and a recording of every regime; all of them or nothing.

    Args:
        name: of a closed-loop scenario.
        folder: appears when it is whole.
    """
    scenario = evaluated_scenario(name)
    rows = []
    with atomic_folder(folder) as partial:
        for i, (regime, of_regime) in enumerate(regime_scenarios(scenario).items()):
            station = make_private_station(of_regime)
            recording = run_station(station)
            recording.save(partial / f"regime_{i}.nc")
            rows.append(_row(regime, of_regime.control.gains, step_table(station, recording)[-1]))
        write_csv(partial / "regimes.csv", rows)
        (partial / "scenario.yaml").write_text(dump_scenario(scenario), encoding="utf-8")


def _row(regime: str, gains: PidGains, step: StepRow) -> RegimeRow:
    followed = step.from_mm, step.to_mm, step.overshoot_percent
    return RegimeRow(regime, *_in_kpa(gains), *followed, step.crossings, step.settling_s)


def read_regimes(folder: Path) -> dict[str, Recording]:
    """Recordings of `run_regimes`, by the names of the regimes."""
    return {regime: Recording.load(folder / f"regime_{i}.nc") for i, regime in enumerate(REGIMES)}


def regimes_figure(scenario: Scenario, recordings: Mapping[str, Recording]) -> Figure:
    """Opening and pressure of every regime of a closed-loop scenario; the legend states the gains."""
    gains = {regime: _in_kpa(one.control.gains) for regime, one in regime_scenarios(scenario).items()}
    texts = {regime: "kp {:.5g}, ki {:.5g}, kd {:.5g}".format(*gains[regime]) for regime in recordings}
    return step_figure({f"{regime}\n{texts[regime]}": recording for regime, recording in recordings.items()})


def _in_kpa(gains: PidGains) -> tuple[float, float, float]:
    """kp, kPa/m, ki, kPa/(m s), and kd, kPa s/m."""
    return gains.kp / 1e3, gains.ki / 1e3, gains.kd / 1e3
