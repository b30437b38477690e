"""Scores estimates by the truth, (T, m) each: errors, coverage of bands and proper scores by region of a task."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.scoring import NORMAL_95, error_columns, percent_within
from studies.benchmark.benchmark_task import BenchmarkTask, Tested
from studies.benchmark.estimates import Answers
from studies.contacts.contact_coverage import interval_score

_SET_PROBABILITY = 0.95  # of the probability, that a set of answers holds


@dataclass(frozen=True)
class Score:
    """The errors of one estimator in one region of a task.

    Errors are distances between outputs, in their unit. A band holds 95 % of normal errors if the stated standard
    deviations are right. In recognition the mean is the share of wrong answers, and the band is the fewest answers that
    have 95 % of the stated probability.
    """

    task: str
    region: str
    estimator: str
    samples: int
    unit: str
    mean: float
    median: float | None  # None in recognition
    percentile_95: float | None
    proper: float  # mean CRPS of single outputs, in the unit; in recognition the Brier score, from 0 to 2
    within_band_percent: float | None  # of single outputs, in their band; None without a band
    band: float | None  # mean width from end to end, in the unit; in recognition the mean number of answers
    unknown_percent: float | None = None  # of answers in recognition
    interval_score: float | None = None  # mean of single outputs, in the unit; None in recognition, or without a band


def scores(task: BenchmarkTask, name: str, answers: Answers, tested: Tested) -> Iterator[Score]:
    """Yields the scores of an estimator in every region with estimates."""
    score_fields = _recognition_score if task.recognition else _error_score
    for region, estimates in answers.items():
        truth = np.vstack([recorded.outputs for recorded in tested[region]])
        mean = np.vstack([estimate.mean for estimate in estimates])
        bands = [estimate.std for estimate in estimates if estimate.std is not None]
        std = np.vstack(bands) if bands else None
        yield Score(task.name, region, name, len(truth), **score_fields(task, truth, mean, std))


def crps(error: Array, std: Array) -> Array:
    """Continuous ranked probability score of normal estimates, in the unit of their errors.

    Its mean is least for an estimator with true standard deviations (Gneiting and Raftery, *JASA* 102, 2007, section
    4.2), and the size of the error if the standard deviation is 0.
    """
    size = np.abs(error)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(std > 0, size / std, np.inf)
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    return size * (2 * ndtr(z) - 1) + std * (2 * density - 1 / np.sqrt(np.pi))


def _error_score(task: BenchmarkTask, truth: Array, mean: Array, std: Array | None) -> dict[str, Any]:
    """Fields of a score of numbers, in the unit of the task's outputs."""
    errors = mean - truth
    distances = error_columns(np.linalg.norm(errors, axis=1), "mean", "median", "percentile_95")
    proper = float(crps(errors, np.zeros_like(errors) if std is None else std).mean())
    coverage = None if std is None else percent_within(errors, NORMAL_95 * std)
    band = None if std is None else NORMAL_95 * std
    width = None if band is None else 2 * float(band.mean())
    interval = None if band is None else float(interval_score(np.stack([-band, band], axis=-1), errors).mean())
    fields = {"proper": proper, "within_band_percent": coverage, "band": width, "interval_score": interval}
    return distances | fields | {"unit": task.outputs[0].unit}


def _recognition_score(task: BenchmarkTask, truth: Array, mean: Array, std: Array | None) -> dict[str, Any]:
    """Fields of a score of recognition; standard deviations are not used."""
    probabilities, true = add_unknown(mean), add_unknown(truth)
    true_class = true.argmax(axis=1)
    order = np.argsort(-probabilities, axis=1, kind="stable")
    mass_before = np.cumsum(np.take_along_axis(probabilities, order, axis=1), axis=1) - np.take_along_axis(
        probabilities, order, axis=1
    )
    is_in_set = mass_before < _SET_PROBABILITY - 1e-9  # the fewest of the likeliest answers
    rank = (order == true_class[:, None]).argmax(axis=1)
    coverage = 100 * float(np.take_along_axis(is_in_set, rank[:, None], axis=1).mean())
    wrong, unknown = (100 * float(is_wrong.mean()) for is_wrong in (rank > 0, order[:, 0] == mean.shape[1]))
    brier = float(((probabilities - true) ** 2).sum(axis=1).mean())
    band = float(is_in_set.sum(axis=1).mean())
    counts = {"mean": wrong, "proper": brier, "within_band_percent": coverage, "band": band, "unknown_percent": unknown}
    return counts | {"unit": "%", "median": None, "percentile_95": None}


def add_unknown(probabilities: Array) -> Array:
    """Appends that of no class to probabilities of classes, (T, C); negative ones count as 0, sums above 1 as 1."""
    positive = np.maximum(probabilities, 0.0)
    total = positive.sum(axis=1, keepdims=True)
    return np.hstack([positive / np.maximum(total, 1.0), np.maximum(1 - total, 0.0)])
