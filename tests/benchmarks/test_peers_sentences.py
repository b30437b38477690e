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


def words(page):
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


def sentences():
    """What the page says around its table, with the numbers of that."""
    free, sensed, obstructed, box, uneven = (ratio(task, "MuJoCo") for task in TASKS)
    peers, tips = ("PyBullet", "PyElastica"), "tip error [mm]"
    free_bullet, free_elastica = (table()["free bending", peer][tips] for peer in peers)
    ours = table()["free bending", "soft-gripper"][tips]
    return [
        f"Free fingers take it {free} of our time at the same error, and {sensed} with sensing on both sides.",
        f"Where fingers meet an obstacle it takes {obstructed} (",
        f"in the box grasp {box}, with almost no creep, and with convex parts of the non-convex body {uneven} of our",
        f"takes {table()['box grasp', 'PyBullet'][EQUAL]} of our time in the box grasp if ours may creep no faster",
        f"within {free_elastica} mm of its own converged run, where we have {ours} mm",
        f"For a free finger PyBullet and PyElastica need {ratio('free bending', 'PyBullet')} and "
        f"{ratio('free bending', 'PyElastica')} times our computing time",
        f"PyBullet's fastest setting that is at least as accurate as ours has {free_bullet} mm",
    ]


@pytest.mark.parametrize("number", range(7))
def test_the_page_says_what_its_table_says(number):
    assert sentences()[number] in words("docs/benchmarks.md")


def test_readme_says_what_the_table_says():
    assert f"MuJoCo takes {ratio('box grasp', 'MuJoCo')} of our computing time for the box grasp" in words("README.md")


def test_every_task_has_a_row_of_each_column():
    rows = table()
    assert {task for task, _ in rows} == set(TASKS)
    assert all(row[EQUAL] for row in rows.values())
