"""The figure of the difference from the paper: every panel shows the chain that its title names."""

import numpy as np
import pytest

from soft_gripper.extras.paper.differences import TipErrors
from soft_gripper.extras.paper.page import difference_figure

BEND = np.radians([0.0, 30.0, 60.0, 30.0])
SIZES = np.arange(16.0).reshape(4, 4) * 1e-3  # m, (sections, steps)
ERRORS = TipErrors((1, 2, 3, 4), SIZES, SIZES + 0.02, SIZES + 0.04)


@pytest.mark.parametrize(
    ("panel", "words", "errors"),
    [
        (0, "joints in the middles of the segments (here)", ERRORS.middles),
        (1, "joints where the segments begin", ERRORS.starts),
        (2, "joints in the middles, readings with 0.1 % noise", ERRORS.noisy),
    ],
)
def test_a_panel_shows_the_errors_of_its_chain(panel: int, words: str, errors: np.ndarray) -> None:
    """In mm against degrees; the second step of the same bend is left out."""
    axes = difference_figure(BEND, ERRORS).axes[panel]
    assert axes.get_title().replace("\n", " ") == words
    assert axes.get_xlabel() == "bend angle [degrees]"
    for n, line in enumerate(axes.lines):
        assert line.get_label() == str(n + 1)
        np.testing.assert_allclose(line.get_xdata(), [0, 30, 60])
        np.testing.assert_allclose(line.get_ydata(), 1e3 * errors[n, :3])


def test_panels_share_one_scale_and_name_the_fingertip() -> None:
    figure = difference_figure(BEND, ERRORS)
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    assert figure.axes[0].get_ylabel() == "fingertip error [mm]"
