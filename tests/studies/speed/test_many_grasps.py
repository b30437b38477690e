"""One command prints what sweeps cost in both engines, by what varies between their runs."""

from pathlib import Path

import pytest

from studies.speed import many_grasps


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
