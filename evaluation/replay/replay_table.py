"""Errors of the estimated places of an arm's bodies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.evaluation.replay.replay_recordings import Replayed, Rows

ALL = "all"


@dataclass(frozen=True)
class ReplayRow:
    """Errors of one estimator over a recording, or over all samples of all of them."""

    estimator: str
    sections: int  # sensors a side
    recording: str
    body: str
    mean_mm: float
    median_mm: float
    percentile_95_mm: float
    max_mm: float


def replay_table(replayed: Sequence[Replayed], rows: Rows) -> list[ReplayRow]:
    """A row for every estimator, body and recording, and for all recordings together.

    The first sample, which is logged before the sensors are read, is left out.
    """
    table = []
    for row, (estimator, sections) in rows.items():
        errors = {one.name: 1e3 * one.signals[f"{row}.body_error"][1:] for one in replayed}
        bodies = next(iter(errors.values()))["body"].values
        for i, body in enumerate(bodies):
            of_body = {name: error.values[:, i] for name, error in errors.items()}
            for name, values in {**of_body, ALL: np.concatenate(list(of_body.values()))}.items():
                seen = values[np.isfinite(values)]
                numbers = seen.mean(), np.median(seen), np.percentile(seen, 95), seen.max()
                table.append(ReplayRow(estimator, sections, name, str(body), *map(float, numbers)))
    return table
