"""One command prints what sweeps cost in both engines, by what varies between their runs."""

import csv
from pathlib import Path

import pytest

from soft_gripper.commands.parser import parsed
from soft_gripper.extras.design.study_file import load_design_study
from soft_gripper.runs.sweep.run_sweep import check_keys, read_axis, sweep_points
from studies.speed import many_grasps


def test_rows_have_the_time_of_both_engines(monkeypatch):
    """MuJoCo takes 2 s and Drake 4 s for a sweep; a search of designs makes three runs."""
    commands = []

    def cpu_time(command):
        options = parsed(command[1:])
        commands.append((command[1], options))
        if command[1] == "design":
            assert load_design_study(options.study).config.designs == 12
            options.out.mkdir()
            with (options.out / "runs.csv").open("w", newline="", encoding="utf-8") as table:
                csv.writer(table).writerows([["stage"], *[["search"]] * 3])
        return {"mujoco": 2.0, "drake": 4.0}[options.engine]

    monkeypatch.setattr(many_grasps, "cpu_time_of", cpu_time)
    rows = [*many_grasps.engine_costs(8)]
    assert [(row.varied, row.runs) for row in rows] == [
        ("friction", 8),
        ("Young's modulus", 8),
        ("a pressure", 8),
        ("designs", 3),
    ]
    assert all((row.mujoco_s, row.drake_s, row.mujoco_over_drake) == (2.0, 4.0, 0.5) for row in rows)
    assert rows[0].mujoco_s_a_run == 0.25
    assert {options.jobs for _, options in commands} == {1}
    axes = [read_axis(text) for name, options in commands if name == "sweep" for text in options.vary]
    for axis in axes:
        check_keys("box_grasp", {}, sweep_points([axis], "latin", 2))


def test_the_page_prints_these_rows():
    page = (Path(__file__).parents[3] / "docs/extras/mujoco_engine/mujoco.md").read_text(encoding="utf-8")
    assert "python -m studies many-grasps --varied" in page
    lines = page.splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| varied |")) + 2
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[start : lines.index("", start)]]
    assert [row[0] for row in rows] == [*many_grasps.VARIED, "designs"]
    for _, runs, mujoco, drake, *a_run, ratio in rows:
        assert float(mujoco) / float(drake) == pytest.approx(float(ratio), abs=0.02)
        assert [float(seconds) / float(runs) for seconds in (mujoco, drake)] == pytest.approx(
            [*map(float, a_run)], abs=0.02
        )
