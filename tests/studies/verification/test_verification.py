"""The tables of docs/verification.md and of the study's README are those that `make verification` prints."""

import re
from pathlib import Path

import numpy as np
import pytest
from printed_numbers import table_problems

from studies.verification.tables import BENT_FINGERS, COMPLIANCE, MIN_LOST_COMPLIANCE, SOLVERS, TABLES

ROOT = Path(__file__).parents[3]
PAGES = ROOT / "docs" / "verification.md", ROOT / "studies" / "verification" / "README.md"
PAGE = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)

FAST = (BENT_FINGERS, COMPLIANCE)
SLOW = [table for table in TABLES if table not in (*FAST, SOLVERS)]
CHECKED = [*FAST, *(pytest.param(table, marks=pytest.mark.published) for table in SLOW)]


def problems(table, page=PAGE):
    rows = list(table.rows())
    if not rows:
        pytest.skip("there are no files in the folder SPATIAL_RODS")
    words = [[float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)] for text, _ in rows]
    numbers = [[number for number in numbers if number <= MIN_LOST_COMPLIANCE] for _, numbers in rows]
    return table_problems(page, table.header, [[*of_text, *rest] for of_text, rest in zip(words, numbers, strict=True)])


@pytest.mark.parametrize("table", CHECKED, ids=lambda table: table.rows.__name__)
def test_the_page_prints_what_the_command_does(table):
    assert not problems(table)


@pytest.mark.published
def test_three_solvers_agree_as_the_page_says():
    pytest.importorskip("elastica")
    tips = np.array([numbers for _, numbers in SOLVERS.rows()]).reshape(-1, 3, 3)  # pressure, solver, axis
    distances = np.linalg.norm(tips[:, :1] - tips[:, 1:], axis=-1).max(axis=0)
    (stated,) = re.findall(r"with the Kirchhoff rod within ([\d.]+) mm .* within ([\d.]+) mm", PAGE)
    assert (distances < [float(number) for number in stated]).all()
