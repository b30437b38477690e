"""The colours of external torque: ends, middle, unknown, and the bar that shows them."""

import numpy as np
import pytest

from soft_gripper.diagrams.view.torque_colors import color, round_limit

LIMIT = 0.2


def test_blue_holds_open_and_red_closes() -> None:
    red, _, blue = color(np.array([-0.1, 0.1]), LIMIT).T
    assert blue[0] - red[0] > 0.3
    assert red[1] - blue[1] > 0.3


@pytest.mark.parametrize("torque", [1.0, 0.19, 0.2, 0.2000001, 0.31, 3e-4, 0.05, 7.0, 12.0])
def test_round_limit_is_the_least_round_number_that_holds_the_torque(torque: float) -> None:
    round_numbers = [float(f"{digit}e{power}") for power in range(-5, 3) for digit in (1, 2, 3, 5)]
    assert round_limit(torque) == pytest.approx(min(n for n in round_numbers if n >= torque))
