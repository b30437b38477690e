"""The picture of soft objects that are carried: its numbers are those of the page."""

import re
from pathlib import Path

import numpy as np
import pytest

from pictures.soft_grasps import OBJECTS, run_grasp

PAGE = (Path(__file__).parents[3] / "docs/extras/soft/soft_objects.md").read_text(encoding="utf-8")


@pytest.mark.published
@pytest.mark.parametrize("name", OBJECTS[:2])
def test_numbers_of_the_page(name: str) -> None:
    (printed,) = re.findall(rf"^\| {name} \| [^|]* \| (.*) \|$", PAGE, re.MULTILINE)
    grasp = run_grasp(name)
    result = grasp.result
    found = (result.peak_force_n, result.squeeze_mm, 100 * grasp.strain.max(), result.slip_mm, result.placed_error_mm)
    np.testing.assert_allclose(found, [float(number) for number in printed.split("|")], atol=0.06)
