"""Functions of many samples, computed a few at a time."""

import tracemalloc

import numpy as np
import pytest

from soft_gripper.estimators.batches import _BATCH_SIZE as N
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.fixture(scope="module")
def contact(shipped_finger):
    return ContactShape(SensorLayout(shipped_finger, sections=2))


def bent_by_a_force(shape, samples):
    """Arguments of an estimator: readings of a finger that a force bends ever more, without pressure."""
    finger = shape.layout.finger
    q = np.linspace(-0.2, -0.201, samples)[:, None] * finger.angle((0.09 - finger.joint_arc_lengths).clip(0))
    return shape.layout.read(q), np.zeros_like(q), np.zeros((samples, 3))


def peak(function, *arguments):
    """Memory that a call takes at most, bytes."""
    tracemalloc.start()
    try:
        function(*arguments)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_a_long_recording_takes_memory_for_its_results_alone(contact):
    """Cells and densities of a sample, a hundred kilobytes, are no longer kept once its posterior is known."""
    few, many = (peak(contact.posterior, *bent_by_a_force(contact, samples)) for samples in (2 * N, 4 * N))
    assert (many - few) / (2 * N) < 2e3


def test_parts_give_what_all_samples_give(contact):
    """An interval that is computed part by part is the one computed when it is asked for."""
    given = bent_by_a_force(contact, N + 4)
    together = contact.posterior(*given)
    for rows in (slice(0, N), slice(N, N + 4)):
        part = contact.posterior(*(values[rows] for values in given))
        np.testing.assert_array_equal(part.force_interval, together.force_interval[rows])
        np.testing.assert_array_equal(part.force_bounds, together.force_bounds[rows])
