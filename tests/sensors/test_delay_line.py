"""Delay lines: whole samples late, and the first sample until it has arrived."""

import numpy as np
import pytest

from soft_gripper.sensors.error_block import pass_delay_line


@pytest.mark.parametrize("delay", [0, 1, 4])
def test_samples_arrive_late(delay):
    line, arrived = np.full((2, delay, 3), np.nan), []
    sent = np.arange(60.0).reshape(10, 2, 3)
    for present in sent:
        line, late = pass_delay_line(line, present)
        arrived.append(late)
    expected = sent[np.maximum(np.arange(10) - delay, 0)]
    np.testing.assert_array_equal(arrived, expected)
