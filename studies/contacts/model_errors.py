"""Coverage of `contact` where finger, sensors or scene differ from what the default uncertainty declares.

A row for each of `situations.DIFFERENCES`, number of sections and kind of sensors, of contacts and of as many fingers
that nothing touches.
"""

import argparse
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np

from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.files.row_table import print_rows
from studies.contacts.contact_coverage import encloses, rms_z
from studies.contacts.situations import DIFFERENCES, NOMINAL, Case, drawn
from studies.kept_rows import counted_jobs, kept_rows

TABLE = "model_errors.csv"
CASES = tuple(Case(*each, NOMINAL) for each in product((2, 4), (False, True)))
_FREE = dict.fromkeys(("inner", "outer"), (0.0, 0.0))  # N


@dataclass(frozen=True)
class ModelErrorRow:
    """Coverage of 95 % intervals of the force and sets of places, where they are stated."""

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


def model_error_rows(difference: str, case: Case, number: int, seed: int) -> list[ModelErrorRow]:
    """The row of a case of about `number` contacts."""
    situation = DIFFERENCES[difference]
    stated = drawn(situation, case, number, seed)
    free = drawn(situation._replace(contacts=partial(situation.contacts, forces=_FREE)), case, number, seed)
    pairs = (
        (stated.interval, stated.force),
        (stated.transverse_interval, stated.transverse),
        (stated.places, stated.place),
    )
    covered = [holds[known] for holds, known in (encloses(*pair) for pair in pairs)]
    masks = *covered, stated.probability > DETECTION_PROBABILITY, free.probability > DETECTION_PROBABILITY
    interval, transverse, place, detected, touched = (100 * float(m.mean()) if len(m) else np.nan for m in masks)
    of_case = difference, case.sections, case.sensors, len(stated.force)
    return [ModelErrorRow(*of_case, interval, transverse, rms_z(stated), place, detected, touched, seed)]


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file, settings = options.out / TABLE, {"contacts": options.contacts, "seed": options.seed}
    jobs = {(name, case): [(name, str(case.sections), case.sensors)] for name, case in product(DIFFERENCES, CASES)}
    with counted_jobs(options, len(jobs), "cases") as (executor, ended):
        rows = kept_rows(file, ModelErrorRow, model_error_rows, jobs, settings, executor, ended, options.resume)
    print_rows(rows)
    options.console.table("model_errors", rows)
    options.console.wrote(file)
