"""The readings of every section that a finger could have, so that each placement only picks its own.

What a sensor reads depends on where its section begins and ends, not on the others. So all spans of whole segments are
read, and disturbed, once; placements that share a section share its errors, and differ by what they are, not by luck.

T samples, N segments, M = N (N + 1) / 2 spans.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.evaluation.placement.placements import Placement
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb


class SpanRatios(NamedTuple):
    """Extension ratios of all spans."""

    ratios: Array  # (..., paths, M)
    segments: int

    def of(self, placement: Placement) -> Array:
        """Those of the sections of a placement, in the order of readings, (..., paths * S)."""
        ends = np.array([0, *placement, self.segments])
        chosen = self.ratios[..., _span_numbers(self.segments)[ends[:-1], ends[1:]]]
        return chosen.reshape(*chosen.shape[:-2], -1)


def span_ratios(segment_sensors: SensorLayout, q: Array) -> SpanRatios:
    """Of ideal sensors, from joint angles (..., N) rad; `segment_sensors` has a section for every segment."""
    segments = segment_sensors.sections
    by_segment = extension_ratios(segment_sensors, q).reshape(*q.shape[:-1], segment_sensors.paths, segments)
    up_to = np.concatenate([np.zeros_like(by_segment[..., :1]), by_segment.cumsum(axis=-1)], axis=-1)
    begin, end = _spans(segments)
    return SpanRatios((up_to[..., end] - up_to[..., begin]) / (end - begin), segments)


def disturbed(
    ideal: SpanRatios, errors: StrainErrors, period: float, seeds: int, rng: np.random.Generator
) -> SpanRatios:
    """The ratios (T, ..., paths, M) as `seeds` sets of sensors with errors give them, (T, ..., seeds, paths, M)."""
    *leading, paths, spans = ideal.ratios.shape
    repeated = np.broadcast_to(ideal.ratios[..., None, :, :], (*leading, seeds, paths, spans))
    flat = repeated.reshape(*leading, seeds, paths * spans)
    return SpanRatios(disturb(errors, flat, period, rng).reshape(repeated.shape), ideal.segments)


def _spans(segments: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Where every span begins and ends, each (M)."""
    begin, end = np.triu_indices(segments + 1, 1)
    return begin, end


def _span_numbers(segments: int) -> NDArray[np.int_]:
    """Which span begins and ends where, (N + 1, N + 1)."""
    numbers = np.zeros((segments + 1, segments + 1), dtype=int)
    begin, end = _spans(segments)
    numbers[begin, end] = np.arange(len(begin))
    return numbers
