"""Numbers that documents print, compared with what `soft-gripper evaluate` wrote, to the last digit that is printed.

What a cell should say is worked out from the CSV files again, in means, largest values and last steps of rows.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

import numpy as np
from printed_numbers import NUMBER, Numbers, begins_with, cells_of

from soft_gripper.extras.paper.claims import Claim, claims
from soft_gripper.extras.paper.contact_table import ContactRow, touched_finger_rows
from soft_gripper.extras.paper.evaluate import CONTACT, FREE, SCENARIOS
from soft_gripper.extras.paper.forces import LAYOUTS, ContactForceRow
from soft_gripper.extras.paper.pose_rows import estimator_rows
from soft_gripper.files.row_table import read_csv
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow

ROOT = Path(__file__).parents[3]
MARK = "<!-- make evaluate -->"  # before a table that the command writes
ESTIMATORS = ("gaussian", "contact")  # whose errors are in a table of their own
SECTIONS = (1, 2, 3, 4)
POSE, TIP = "pose_error_mm", "tip_error_mm"


@dataclass(frozen=True)
class Written:
    """The tables in the folder of an evaluation; of scenarios with contact the fingers that touch something."""

    folder: Path

    @cached_property
    def contacts(self) -> list[ContactRow]:
        return read_csv(self.folder / "contact.csv", ContactRow)

    @cached_property
    def poses(self) -> list[PoseRow]:
        return touched_finger_rows(read_csv(self.folder / "metrics.csv", PoseRow), self.contacts)

    @cached_property
    def forces(self) -> list[ForceRow]:
        rows = estimator_rows(read_csv(self.folder / "forces.csv", ForceRow), "arcs")
        return touched_finger_rows(rows, self.contacts)

    @cached_property
    def pressing(self) -> list[ContactForceRow]:
        return touched_finger_rows(read_csv(self.folder / "contact_forces.csv", ContactForceRow), self.contacts)

    @cached_property
    def claims(self) -> list[Claim]:
        """Those of the paper; the report of the command has all."""
        found = claims(estimator_rows(self.poses, "arcs"), self.forces)
        return [claim for claim in found if claim.source == "paper"]

    def errors(self, scenario: str, sections: int, column: str = POSE, estimator: str = "arcs") -> Numbers:
        """Of every step and finger, mm."""
        wanted = scenario, sections, estimator
        return [getattr(row, column) for row in self.poses if (row.scenario, row.sections, row.estimator) == wanted]

    def mean(self, scenario: str, sections: int, column: str = POSE, estimator: str = "arcs") -> float:
        return float(np.mean(self.errors(scenario, sections, column, estimator)))


def _errors_by_sections(column: str) -> Callable[[Written], list[Numbers]]:
    def rows(w: Written) -> list[Numbers]:
        return [[*(w.mean(s, n, column) for n in SECTIONS), max(w.errors(s, 4, column))] for s in SCENARIOS]

    return rows


def _errors_by_estimator(w: Written) -> list[Numbers]:
    return [[w.mean(s, n, POSE, name) for n in (1, 2, 4)] for s in CONTACT for name in ESTIMATORS]


def _torques(w: Written) -> list[Numbers]:
    """At the last step: mean errors over joints and fingers, mN m, and the base torque of the first finger."""
    found = []
    for scenario in CONTACT:
        rows = [row for row in w.forces if row.scenario == scenario]
        last = [row for row in rows if row.pressure_kpa == rows[-1].pressure_kpa]
        of = [[row for row in last if row.sections == n] for n in SECTIONS]
        errors = [1e3 * float(np.mean([abs(row.estimated_nm - row.true_nm) for row in part])) for part in of]
        found.append([*errors, 1e3 * of[-1][0].true_nm, 1e3 * of[-1][0].estimated_nm])
    return found


def _contact_forces(w: Written) -> list[Numbers]:
    """At the last step, of the first finger: force, N, and place, mm, true and by every layout."""
    found = []
    for scenario in CONTACT[1:]:
        rows = [row for row in w.pressing if row.scenario == scenario]
        last = [r for r in rows if (r.finger, r.pressure_kpa) == (rows[0].finger, rows[-1].pressure_kpa)]
        assert len(last) == len(LAYOUTS)
        estimated = chain(*((row.estimated_n, row.estimated_mm) for row in last))
        found.append([last[0].true_n, last[0].true_mm, *estimated])
    return found


TABLES: dict[tuple[str, str], Callable[[Written], list[Numbers]]] = {
    ("docs/evaluation.md", "mean pose error [mm] | 1 | 2 | 3 | 4 sensors per side"): _errors_by_sections(POSE),
    ("docs/evaluation.md", "mean pose error [mm] | estimator | 1"): _errors_by_estimator,
    ("docs/evaluation.md", "mean torque error at the last step [mN m]"): _torques,
    ("docs/evaluation.md", "at the last step | true | 2, at 60 mm | 2, at 40 mm | 4"): _contact_forces,
    ("docs/evaluation.md", "claim of the paper | measured"): lambda w: [_numbers_of(claim) for claim in w.claims],
}
SENTENCES: dict[tuple[str, str], Callable[[Written], Numbers]] = {
    (
        "README.md",
        r"mean error # mm in the worst scenario; constant-curvature arcs from four sensors: # mm",
    ): lambda w: [_worst(w, 2)[0], max(w.mean(s, 4) for s in SCENARIOS)],
    (
        "docs/evaluation.md",
        r"within # mm \(mean of the worst scenario; # mm at the worst step\), where `arcs` with four have # mm",
    ): lambda w: [*_worst(w, 2), max(w.mean(s, 4) for s in SCENARIOS)],
    (
        "docs/evaluation.md",
        r"With one it is # mm \(mean of the worst scenario; # mm at the worst step, and there # mm at the tip\)",
    ): lambda w: [*_worst(w, 1), max(max(w.errors(s, 1, TIP, "gaussian")) for s in SCENARIOS)],
    ("docs/evaluation.md", r"On the uneven body # links touch, over # mm"): lambda w: [
        max(getattr(row, name) for row in w.contacts if row.scenario == "irregular_grasp")
        for name in ("touching_links", "contact_length_mm")
    ],
    ("docs/evaluation.md", r"`recursive` is within # mm of `gaussian` in every mean"): lambda w: [
        max(abs(w.mean(s, n, POSE, "recursive") - w.mean(s, n, POSE, "gaussian")) for s in SCENARIOS for n in SECTIONS)
    ],
    ("docs/evaluation.md", r"error falls from # mm with one sensor to # mm with four"): lambda w: [
        w.mean(FREE, 1, TIP),
        w.mean(FREE, 4, TIP),
    ],
}


def _worst(w: Written, sections: int) -> Numbers:
    """The largest mean and the largest error of `gaussian` over all scenarios, mm."""
    errors = [w.errors(scenario, sections, POSE, "gaussian") for scenario in SCENARIOS]
    return [max(map(np.mean, errors)), max(map(max, errors))]


def _numbers_of(claim: Claim) -> Numbers:
    """Those that its text and what was measured of it print."""
    return [float(number) for number in NUMBER.findall(f"{claim.text} {claim.number}")]


def unguarded(document: str, text: str) -> list[str]:
    """Headers of tables that are marked as written by the command, and that nothing compares."""
    known = [header for name, header in TABLES if name == document]
    marked = [cells_of(line) for line in re.findall(rf"{MARK}\n(\|.*)", text)]
    return [" | ".join(cells) for cells in marked if not any(begins_with(cells, header) for header in known)]
