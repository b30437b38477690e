"""What pages say of other simulators is so in the table of docs/benchmarks.md."""

from pathlib import Path

EQUAL = "time ÷ ours, if ours must be as good"
ROOT = Path(__file__).parents[3]
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


def test_mujoco_is_faster_in_every_task():
    assert all(float(ratio(task, "MuJoCo")) < 1 for task in TASKS)


def test_pybullet_is_faster_at_equal_creep():
    assert float(table()["box grasp", "PyBullet"][EQUAL]) < 1
