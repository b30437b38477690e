"""Spans read once are the sections that a layout with these borders reads."""

import numpy as np
import pytest

from soft_gripper.extras.placement.placements import all_placements, as_borders
from soft_gripper.extras.placement.samples import disturbed, span_ratios
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors


@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize("count", [1, 2, 3, 12])
def test_every_placement_reads_what_its_layout_reads(shipped_finger, bent, count, one_sided):
    q = bent(3, 12)
    spans = span_ratios(SensorLayout(shipped_finger, 12, one_sided), q)
    for placement in all_placements(12, count):
        layout = SensorLayout(shipped_finger, count, one_sided, borders=as_borders(placement, 12))
        np.testing.assert_allclose(spans.of(placement), extension_ratios(layout, q), rtol=1e-13)


@pytest.fixture
def spans(shipped_finger, bent):
    """Of 40 samples."""
    return span_ratios(SensorLayout(shipped_finger, 12), bent(40, 12))


def test_sensors_without_errors_read_what_is_true(spans):
    read = disturbed(spans, StrainErrors(), 0.01, 3, np.random.default_rng(1))
    for i in range(3):
        np.testing.assert_allclose(read.ratios[:, i], spans.ratios, atol=1e-15)


def test_sensors_of_a_set_and_sets_differ_by_their_noise(spans):
    read = disturbed(spans, StrainErrors(noise=0.01), 0.01, 3, np.random.default_rng(1))
    noise = read.ratios - spans.ratios[:, None]
    assert noise.shape == (40, 3, 2, 78)
    assert noise.std() == pytest.approx(0.01, rel=0.03)
    by_sensor = noise.reshape(40, -1).T
    correlation = np.corrcoef(by_sensor[:100])
    assert np.abs(correlation - np.eye(100)).max() < 0.75  # of 40 samples; equal sensors have 1


def test_an_offset_stays_through_the_samples(spans):
    read = disturbed(spans, StrainErrors(offset=0.01), 0.01, 2, np.random.default_rng(1))
    offset = read.ratios - spans.ratios[:, None]
    np.testing.assert_allclose(offset, np.broadcast_to(offset[:1], offset.shape), atol=1e-14)
    assert offset[0].std() == pytest.approx(0.01, rel=0.2)


def test_placements_share_the_errors_of_a_shared_section(spans):
    read = disturbed(spans, StrainErrors(noise=0.01), 0.01, 2, np.random.default_rng(1))
    np.testing.assert_array_equal(read.of((4,))[..., [0, 2]], read.of((4, 7))[..., [0, 3]])
