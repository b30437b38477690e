"""Sweeps: rows, resumed tables, and their figure."""

import csv
import fcntl
import os

import numpy as np
import pytest
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.sweeps import measured_runs, scenario_runs, sweep
from soft_gripper.extras.sweeps.cells import cell
from soft_gripper.extras.sweeps.figure import sweep_figure
from soft_gripper.extras.sweeps.measured_runs import STEP, depends_on_step
from soft_gripper.extras.sweeps.sweep import ABOUT, TABLE, run_sweep
from soft_gripper.files.output import release_folders

MEASURES = {
    "mean_pose_error_mm": 1.0,
    "max_pose_error_mm": 2.0,
    "mean_tip_error_mm": 3.0,
    "max_tip_error_mm": 4.0,
    "mean_torque_error_mnm": 5.0,
    "largest_bend_deg": 6.0,
    "largest_contact_force_n": float("nan"),
}
KEY = "sensor.sections"
SECTIONS = [{KEY: n} for n in (1, 2, 3, 4)]


@pytest.fixture
def executor(monkeypatch):
    """Runs nothing; two sections diverge."""

    def run(scenario, runs, own, check_step):
        (changes,) = runs
        if changes[KEY] == 2:
            raise SimulationDivergedError("the simulation\ndiverged")
        return [MEASURES | {"mean_pose_error_mm": 1 / changes[KEY], "max_pose_error_mm": changes["sensor.period"]}]

    monkeypatch.setattr(scenario_runs, "measured_runs", run)
    monkeypatch.setattr(sweep, "check_closed", lambda station: None)
    monkeypatch.setattr(sweep, "make_station", lambda scenario: None)
    return HereExecutor()


def records(folder):
    with (folder / TABLE).open(newline="") as file:
        return list(csv.DictReader(file))


def swept(folder, executor, points=SECTIONS, **options):
    return run_sweep("free_bending", points, folder, executor, fixed={"sensor.period": 0.02}, **options)


def test_every_run_has_a_row_and_a_failure_says_why(executor, tmp_path):
    reported = []
    swept(tmp_path, executor, report=reported.append)
    rows = records(tmp_path)
    assert [row["run"] for row in rows] == ["0", "1", "2", "3"]
    assert [row[KEY] for row in rows] == ["1", "2", "3", "4"]
    assert [row["mean_pose_error_mm"] for row in rows] == ["1", "", "0.333333333", "0.25"]
    assert [row["max_pose_error_mm"] for row in rows] == ["0.02", "", "0.02", "0.02"]
    assert [row["error"] for row in rows] == ["", "the simulation diverged", "", ""]
    assert sorted(reported) == [False, True, True, True]


def test_what_was_cut_short_goes_on_to_the_same_table(executor, tmp_path):
    swept(tmp_path / "whole", executor)
    swept(tmp_path / "cut", executor)
    whole = (tmp_path / "whole" / TABLE).read_bytes()
    (tmp_path / "cut" / TABLE).write_bytes(whole[:-10])
    executor.calls.clear()
    swept(tmp_path / "cut", executor, resume=True)
    assert (tmp_path / "cut" / TABLE).read_bytes() == whole
    assert [changes[KEY] for _, (changes,), *_ in executor.calls] == [4]
    executor.calls.clear()
    swept(tmp_path / "cut", executor)
    assert len(executor.calls) == 4


@pytest.mark.parametrize("file", [TABLE, ABOUT])
def test_what_is_not_text_is_not_resumed(file, executor, tmp_path):
    swept(tmp_path, executor)
    (tmp_path / file).write_bytes(b"\xff\n")
    with pytest.raises(InputError) as error:
        swept(tmp_path, executor, resume=True)
    assert error.value.value == file


def test_another_sweep_is_not_resumed(executor, tmp_path):
    swept(tmp_path, executor)
    for other in ({"points": SECTIONS[:3]}, {"fixed": {"sensor.period": 0.04}}):
        arguments = {"points": SECTIONS, "fixed": {"sensor.period": 0.02}} | other
        with refused("--resume"):
            run_sweep("free_bending", out=tmp_path, executor=executor, resume=True, **arguments)


def test_two_sweeps_do_not_write_into_one_folder(executor, tmp_path):
    lock = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    with refused("folder"):
        swept(tmp_path, executor)
    os.close(lock)
    swept(tmp_path, executor)
    release_folders()


@pytest.mark.parametrize(
    ("key", "value", "field", "found"),
    [
        ("sensor.section", 1, "sensor.section", 1),
        ("sensor.sections", 0, "sensor.sections", 0),
        ("sensor.sections.more", 1, "sensor.sections", {"more": 1}),
        ("description", "other", "--vary", "description"),
        ("control.set_points", [0.05], "--vary", "control.set_points"),
    ],
)
def test_keys_that_cannot_vary_are_refused_before_anything_runs(executor, tmp_path, key, value, field, found):
    with refused(field, found) as caught:
        swept(tmp_path / "out", executor, [{key: value}])
    assert key in str(caught.value)
    assert not executor.calls
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("value", "text"),
    [(float("nan"), "nan"), (True, "True"), (3, "3"), (1e-7, "1e-07"), (-0.0, "0"), ([1, 2], "[1, 2]"), (None, "")],
)
def test_cells(value, text):
    assert cell(value) == text


def test_what_is_varied_counts_before_what_is_fixed(executor, tmp_path):
    run_sweep("free_bending", SECTIONS[2:], tmp_path, executor, fixed={"sensor.period": 0.02, KEY: 1})
    assert [changes[KEY] for _, (changes,), *_ in executor.calls] == [3, 4]


def test_measures_that_change_with_the_step_are_named():
    """By more than 5 % and by more than a hundredth of their units; and words that differ."""
    coarse = {"same": 1.0, "tiny": 0.001, "changed": 2.0, "lost": "held", "unknown": float("nan"), "gone": 1.0}
    fine = {
        "same": 1.04,
        "tiny": 0.009,
        "changed": 2.2,
        "lost": "dropped",
        "unknown": float("nan"),
        "gone": float("nan"),
    }
    assert depends_on_step(coarse, fine) == ["changed", "lost", "gone"]


def test_a_checked_sweep_has_a_column_for_what_depends_on_the_step(tmp_path, monkeypatch):
    steps = []

    def measured(scenarios, own):
        steps.extend(scenario.plant_config.time_step for scenario in scenarios)
        return (MEASURES | {"largest_bend_deg": scenario.plant_config.time_step} for scenario in scenarios)

    monkeypatch.setattr(measured_runs, "_all_measures", measured)
    monkeypatch.setattr(sweep, "check_closed", lambda station: None)
    monkeypatch.setattr(sweep, "make_station", lambda scenario: None)
    fixed = {STEP: 1.0}
    run_sweep("free_bending", SECTIONS[:1], tmp_path, HereExecutor(), fixed=fixed, check_step=True)
    assert steps == [1.0, 0.5]
    assert records(tmp_path)[0]["depends_on_step"] == "largest_bend_deg"
    with refused(STEP, 0.0):
        run_sweep("free_bending", SECTIONS[:1], tmp_path, HereExecutor(), fixed={STEP: 0.0}, check_step=True)


DRAWN_MEASURES = {"error_mm": ["1", "", "3", "nan"], "outcome": ["done", "", "lost", "done"]}


def test_true_and_false_are_drawn_as_one_and_zero():
    (axes,) = sweep_figure({"key": ["1", "2", "3"]}, {"is_held": ["True", "False", ""]}, "").axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [1, 0, np.nan])


def test_a_map_of_a_grid_and_dots_of_samples_with_crosses_where_runs_failed():
    grid = sweep_figure({"a": ["1", "1", "2", "2"], "b": ["5", "6", "5", "6"]}, DRAWN_MEASURES, "").axes[0]
    np.testing.assert_array_equal(np.ma.filled(grid.collections[0].get_array(), np.nan), [[1, 3], [np.nan, np.nan]])
    assert len(grid.lines[0].get_xdata()) == 2
    dots = sweep_figure({"a": ["1", "1.5", "2", "3"], "b": ["5", "6", "7", "6"]}, DRAWN_MEASURES, "").axes[0]
    np.testing.assert_array_equal(dots.collections[0].get_offsets(), [[1, 5], [2, 7]])


@pytest.mark.parametrize(
    ("varied", "measured"), [({k: ["1"] for k in "abc"}, {"m": ["1"]}), ({"a": ["1"]}, {"m": [""], "n": ["done"]})]
)
def test_what_cannot_be_drawn_has_no_figure(varied, measured):
    assert sweep_figure(varied, measured, "") is None


def test_many_points_are_an_image_in_an_svg(tmp_path):
    cells = [str(value) for value in range(20_000)]
    figure = sweep_figure({"a": cells, "b": cells[::-1]}, {"measure": cells}, "")
    assert figure is not None
    figure.savefig(tmp_path / "sweep.svg")
    assert (tmp_path / "sweep.svg").stat().st_size < 1e6
