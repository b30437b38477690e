"""The regimes of the grip control: one rings, one is well damped, one creeps, whatever the shipped gains are."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.evaluation.paper.scenario_run import evaluated_scenario, is_finished
from soft_gripper.evaluation.pid_regimes import (
    REGIMES,
    RegimeRow,
    read_regimes,
    regime_scenarios,
    regimes_figure,
    run_regimes,
)
from soft_gripper.files.csv_table import read_csv
from soft_gripper.files.output import SUMS
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

NAME = "tip_distance_steps"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a run of all regimes leaves."""
    folder: Path = tmp_path_factory.mktemp("results") / "regimes"
    run_regimes(NAME, folder)
    return folder


@pytest.fixture(scope="module")
def rows(folder: Path) -> list[RegimeRow]:
    return read_csv(folder / "regimes.csv", RegimeRow)


def test_the_step_is_the_largest_of_the_scenario_and_only_the_integral_gain_differs() -> None:
    scenario = load_scenario(NAME, ["control.set_points=[0.08, 0.07, 0.1, 0.09]", "control.gains.ki=4e6"])
    regimes = regime_scenarios(scenario)
    assert list(regimes) == list(REGIMES)
    for factor, regime in zip(REGIMES.values(), regimes.values(), strict=True):
        assert regime.control.set_points == [0.07, 0.1]
        assert regime.control.gains.ki == pytest.approx(factor * 4e6)
        assert (regime.control.gains.kp, regime.control.gains.kd) == (
            scenario.control.gains.kp,
            scenario.control.gains.kd,
        )
    assert scenario.control.set_points == [0.08, 0.07, 0.1, 0.09]


def test_the_largest_step_may_close_the_gripper() -> None:
    scenario = load_scenario(NAME, ["control.set_points=[0.08, 0.09, 0.05, 0.07]"])
    assert all(regime.control.set_points == [0.09, 0.05] for regime in regime_scenarios(scenario).values())


def test_the_first_rings_the_second_is_well_damped_and_the_third_creeps(rows: list[RegimeRow]) -> None:
    """Of the rings at least two lie beyond the set point and two before it; all settle, the shipped gains soonest."""
    ringing, shipped, creeping = rows
    assert ringing.overshoot_percent > 30
    assert ringing.crossings >= 4
    assert shipped.overshoot_percent < 5
    assert shipped.crossings <= 1
    assert creeping.overshoot_percent == 0
    assert creeping.crossings == 0
    assert ringing.settling_s > 1.5 * shipped.settling_s
    assert creeping.settling_s > 2 * shipped.settling_s


def test_rows_state_the_gains_and_the_step_of_their_regime(rows: list[RegimeRow]) -> None:
    for row, regime in zip(rows, regime_scenarios(load_scenario(NAME)).values(), strict=True):
        gains, (begin, end) = regime.control.gains, regime.control.set_points or []
        assert (row.kp_kpa, row.ki_kpa, row.kd_kpa) == pytest.approx((gains.kp / 1e3, gains.ki / 1e3, gains.kd / 1e3))
        assert row.to_mm == pytest.approx(1e3 * end)
        assert row.from_mm == pytest.approx(1e3 * begin, abs=0.05 * 1e3 * abs(end - begin))


def test_the_figure_shows_every_regime_with_its_own_gains(folder: Path, rows: list[RegimeRow]) -> None:
    recordings = read_regimes(folder)
    opening, _ = regimes_figure(load_scenario(NAME), recordings).axes
    *lines, _ = opening.lines
    for line, row in zip(lines, rows, strict=True):
        regime, gains = str(line.get_label()).split("\n")
        assert regime == row.regime
        assert gains == f"kp {row.kp_kpa:.5g}, ki {row.ki_kpa:.5g}, kd {row.kd_kpa:.5g}"
        drawn = np.asarray(line.get_ydata())
        np.testing.assert_array_equal(drawn, 1e3 * recordings[regime]["grip.opening"].values)
        beyond = (drawn[len(drawn) // 2 :] - row.to_mm) / (row.to_mm - row.from_mm)
        assert 100 * beyond.max() == pytest.approx(max(row.overshoot_percent, 0), abs=0.1)


def test_a_run_leaves_a_whole_folder(folder: Path) -> None:
    assert is_finished(folder, evaluated_scenario(NAME))
    assert {path.name for path in folder.iterdir()} == {
        SUMS,
        "scenario.yaml",
        "regimes.csv",
        *(f"regime_{i}.nc" for i in range(len(REGIMES))),
    }
    assert all(isinstance(recording, Recording) for recording in read_regimes(folder).values())
