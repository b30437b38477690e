"""What is known of a force in a grasp: little along the line from the base, as docs/theory/contact.md says."""

import numpy as np
import pytest

from pictures.force_ellipses import CASES, read_press


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_ellipse_is_long_along_the_line_and_holds_the_truth(name: str) -> None:
    press = read_press(name)
    line = press.point / np.linalg.norm(press.point)
    across = np.array([line[1], -line[0]])
    along, over = (np.sqrt(axis @ press.covariance @ axis) for axis in (line, across))
    assert 5 < along / over < 8
    error = press.true - press.force
    assert error @ np.linalg.solve(press.covariance, error) < 5.99  # chi-squared of two, 95 %
    assert abs(error @ across) < 0.1 * np.linalg.norm(press.true)
