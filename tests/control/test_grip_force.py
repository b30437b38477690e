"""GripForce: the mean of what presses on the fingers."""

import numpy as np
import pytest

from soft_gripper.control.grip import GripForce
from soft_gripper.signals import signal_of


def grip_force(*forces):
    """What the block makes of the contact forces of some fingers, N."""
    block = GripForce([f"f{i}" for i in range(len(forces))])
    context = block.CreateDefaultContext()
    for i, force in enumerate(forces):
        block.GetInputPort(f"f{i}.contact_force").FixValue(context, [force])
    (found,) = block.GetOutputPort("force").Eval(context)
    return found


@pytest.mark.parametrize("forces", [(0.5, 0.7), (0.3, 0.6, 0.9), (-0.2, 0.4)])
def test_is_the_mean(forces):
    assert grip_force(*forces) == pytest.approx(np.mean(forces))


def test_a_force_that_is_not_known_leaves_it_unknown():
    assert np.isnan(grip_force(0.5, np.nan))


def test_is_a_force():
    assert signal_of(GripForce(["a", "b"]).GetOutputPort("force")).unit == "N"
