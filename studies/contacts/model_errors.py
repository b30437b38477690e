"""Coverage of `contact` where finger, sensors or scene differ from what the default uncertainty declares.

In: the DIFFERENCES of `situations` and SETUPS. Out: a row for each pair, of contacts and of as many fingers that
nothing touches. Another difference is an entry of DIFFERENCES.
"""

import argparse
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np

from soft_gripper.files.row_table import print_rows
from studies.contacts.contact_coverage import encloses, rms_z
from studies.contacts.situations import DIFFERENCES, static_estimates
from studies.estimator_setup import NOMINAL, EstimatorSetup
from studies.kept_rows import counted_jobs, kept_rows

TABLE = "model_errors.csv"
SETUPS = tuple(EstimatorSetup(*values, NOMINAL) for values in product((2, 4), (0.0, 1.0)))
_NO_FORCES = dict.fromkeys(("inner", "outer"), (0.0, 0.0))  # N


@dataclass(frozen=True)
class ModelErrorRow:
    """Coverage of 95 % intervals of the force and sets of locations, where they are stated."""

    difference: str
    sections: int
    sensors: str
    contacts: int
    interval_percent: Annotated[float, ".1f"]
    transverse_percent: Annotated[float, ".1f"]  # of the intervals of the transverse force
    transverse_rms_z: Annotated[float, ".2f"]
    place_percent: Annotated[float, ".1f"]
    detected_percent: Annotated[float, ".1f"]  # of the contacts
    touched_percent: Annotated[float, ".1f"]  # of as many free fingers, in which a contact is detected
    seed: int


def model_error_rows(difference: str, setup: EstimatorSetup, number: int, seed: int) -> list[ModelErrorRow]:
    """The row of a difference and a setup, of about `number` contacts."""
    situation = DIFFERENCES[difference]
    untouched = situation._replace(contacts=partial(situation.contacts, forces=_NO_FORCES))
    touched_estimates, free = (static_estimates(contacts, setup, number, seed) for contacts in (situation, untouched))
    pairs = (
        (touched_estimates.interval, touched_estimates.force),
        (touched_estimates.transverse_interval, touched_estimates.transverse),
        (touched_estimates.location_set, touched_estimates.location),
    )
    coverages = [covers[stated] for covers, stated in (encloses(*pair) for pair in pairs)]
    masks = *coverages, touched_estimates.is_detected, free.is_detected
    interval, transverse, location, detected, false = (100 * float(m.mean()) if len(m) else np.nan for m in masks)
    key, count = (difference, setup.sections, setup.sensors), len(touched_estimates.force)
    return [ModelErrorRow(*key, count, interval, transverse, rms_z(touched_estimates), location, detected, false, seed)]


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file, settings = options.out / TABLE, {"contacts": options.contacts, "seed": options.seed}
    jobs = {(name, setup): [(name, str(setup.sections), setup.sensors)] for name, setup in product(DIFFERENCES, SETUPS)}
    with counted_jobs(options, len(jobs), "cases") as (executor, ended):
        rows = kept_rows(file, ModelErrorRow, model_error_rows, jobs, settings, executor, ended, options.resume)
    print_rows(rows)
    options.console.table("model_errors", rows)
    options.console.wrote(file)
