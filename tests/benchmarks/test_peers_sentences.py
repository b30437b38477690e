"""README and docs say of other simulators what the table of docs/benchmarks.md says, digit by digit."""

from pathlib import Path

import pytest

EQUAL = "time ÷ ours, if ours must be as good"
ROOT = Path(__file__).parents[2]
TASKS = ("free bending", "free bending, sensed", "obstructed", "box grasp", "non-convex grasp")


def table():
    """The rows of the benchmark by task and simulator; the columns by their headings."""
    lines = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| task |"))
    headings, rows = cells(lines[start]), {}
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        row = dict(zip(headings, cells(line), strict=True))
        rows[row["task"], row["simulator"].strip("*")] = row
    return rows


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def ratio(task, simulator):
    return table()[task, simulator]["time ÷ ours"]


def error(task, simulator):
    return f"{float(table()[task, simulator]['tip error [mm]']):.2f}"


def words(page):
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


def sentences():
    """What README says, with the numbers of the table."""
    free, sensed, obstructed, box, uneven = (ratio(task, "MuJoCo") for task in TASKS)
    return [
        f"MuJoCo takes {free} of our computing time for free fingers, {sensed} with sensing on both sides, "
        f"{obstructed} where fingers meet an obstacle, {box} in the box grasp and {uneven} with a non-convex body",
        f"its tips rest {error('box grasp', 'MuJoCo')} mm from their converged positions in the box grasp",
        f"PyBullet takes {ratio('free bending', 'PyBullet')} times our time for free fingers (error "
        f"{error('free bending', 'PyBullet')} mm, ours {error('free bending', 'soft-gripper')} mm)",
        f"and {ratio('box grasp', 'PyBullet')} times in the box grasp, but "
        f"{table()['box grasp', 'PyBullet'][EQUAL]} of it if our box may creep no faster",
        f"PyElastica takes {ratio('free bending', 'PyElastica')} times our time at the longest step it can take, with "
        f"an error of {error('free bending', 'PyElastica')} mm",
        f"{free} of our time for free fingers, {box} for the box grasp",
        f"comes within {error('free bending', 'PyElastica')} mm of its converged run, where we have "
        f"{error('free bending', 'soft-gripper')} mm. It takes {ratio('free bending', 'PyElastica')} times our "
        "computing time",
    ]


@pytest.mark.parametrize("number", range(7))
def test_readme_says_what_the_table_says(number):
    assert sentences()[number] in words("README.md")


def test_limitations_say_what_the_table_says():
    free, sensed, obstructed, box, uneven = (ratio(task, "MuJoCo") for task in TASKS)
    expected = (
        f"{free} of our time for free fingers, {sensed} with sensing, {obstructed} at an obstacle, {box} in the box"
    )
    assert f"{expected} grasp and {uneven}" in words("docs/limitations.md")


def test_every_task_has_a_row_of_each_column():
    rows = table()
    assert {task for task, _ in rows} == set(TASKS)
    assert all(row[EQUAL] for row in rows.values())
