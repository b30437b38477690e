"""GripForce and GripForceBound: the mean of what presses on the fingers, and of what it hardly exceeds."""

import numpy as np
import pytest

from soft_gripper.control.grip import GripForce, GripForceBound


def grip_force(*forces):
    """What the block makes of the closing forces of some fingers, N."""
    block = GripForce([f"f{i}" for i in range(len(forces))])
    context = block.CreateDefaultContext()
    for i, force in enumerate(forces):
        block.GetInputPort(f"f{i}.contact_force_vector").FixValue(context, [-force, 5.0, -7.0])
    (found,) = block.GetOutputPort("force").Eval(context)
    return found


def test_a_force_that_is_not_known_leaves_it_unknown():
    assert np.isnan(grip_force(0.5, np.nan))


def grip_force_bound(*fingers):
    """What the block makes of the intervals, N, and contact of some fingers."""
    block = GripForceBound([f"f{i}" for i in range(len(fingers))])
    context = block.CreateDefaultContext()
    for i, (interval, contact) in enumerate(fingers):
        block.GetInputPort(f"f{i}.contact_force_interval").FixValue(context, interval)
        block.GetInputPort(f"f{i}.contact").FixValue(context, [contact])
    (found,) = block.GetOutputPort("force").Eval(context)
    return found


UNKNOWN = 3 * [np.nan]


@pytest.mark.parametrize(
    ("fingers", "expected"),
    [
        ([([0.2, 0.5, 0.8], 1.0), ([0.3, 0.4, 0.6], 1.0)], 0.7),
        ([([0.2, 0.5, 0.8], 1.0), ([0.3, 0.4, 6.0], 0.0)], 0.4),  # one is free, and moved
        ([([0.2, 0.5, 2.5], 0.0), (UNKNOWN, 0.0)], 0.0),
        ([([0.2, 0.5, 0.8], 1.0), (UNKNOWN, 1.0)], np.nan),
    ],
)
def test_the_bound_counts_where_contact_is_detected(fingers, expected):
    assert grip_force_bound(*fingers) == pytest.approx(expected, nan_ok=True)
