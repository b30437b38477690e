"""A criterion of success of a scenario, as text: "slid_mm at most 1", "grasp is held".

Criteria compare the measures of `runs.measures`: another measure there can be named in one.
"""

import math
import re
from typing import Any, NamedTuple

from soft_gripper.files.number import is_number

FORM = "MEASURE at most NUMBER, MEASURE at least NUMBER, or MEASURE is TEXT, with a measure of a sweep"
_CRITERION_PATTERN = re.compile(r"(\w+) (at most|at least|is) (\S.*)")


class Criterion(NamedTuple):
    """A condition on a measure of a run."""

    text: str
    measure: str
    relation: str  # "at most", "at least" or "is"
    value: str

    def is_met(self, measured: Any) -> bool:
        """Whether a run with this value of the measure meets the criterion; NaN never does."""
        if self.relation == "is":
            return str(measured) == self.value
        bound = float(self.value)
        return bool(measured <= bound if self.relation == "at most" else measured >= bound)


def read_criterion(text: str) -> Criterion | None:
    """Parses a criterion; None if it has another form than FORM."""
    match = _CRITERION_PATTERN.fullmatch(text)
    if match is None:
        return None
    criterion = Criterion(text, *match.groups())
    is_bound = is_number(criterion.value.strip()) and math.isfinite(float(criterion.value))
    return criterion if criterion.relation == "is" or is_bound else None
