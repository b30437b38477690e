"""ContactForces: the contact force of every finger of a recording, true and estimated, with the band of the latter.

It is the transverse force: the part at right angles to the line from the base of the finger to the contact, which bends
the finger. A force along that line has no lever about the base, so that friction along the finger, which is unknown,
trades against the force along the normal, which is given as well: its median error is about twice as large with
realistic sensors, and up to ten times with ideal ones. The closing force is the component against the direction in
which the finger closes; those of two fingers that hold an object are equal.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import CLOSING
from soft_gripper.estimators.force_posterior import INTERVAL, NOTHING
from soft_gripper.estimators.plane import to_base
from soft_gripper.files.row_table import UNKNOWN, table_text

if TYPE_CHECKING:  # imported when a signal is read
    import xarray as xr

_TRUE_FORCE, _ESTIMATED_FORCE = "true_transverse_force", "transverse_force"
_NO_FORCE = "the recording has neither; record.truth: all records the true force, estimator.type: contact estimates it"
_NO_ESTIMATE = "No contact force was estimated: the estimator contact estimates it (estimator.type: contact)."


@dataclass(frozen=True)
class FingerForce:
    """The contact force on a finger at one time; NaN where it is not known, locations also without contact.

    true_transverse_n, transverse_n: size of the force at right angles to the line from the base to the contact.
    least_n, most_n: the band of its estimate, which holds the true one with a probability of 95 %.
    true_closing_n, closing_n: along -x of the base of the finger.
    true_normal_n, normal_n: across the finger in its bending plane, positive on the inner side.
    true_mm, estimated_mm: contact location along the finger, from its base.
    """

    finger: str
    time_s: float
    true_transverse_n: float
    transverse_n: float
    least_n: float
    most_n: float
    true_closing_n: float
    closing_n: float
    true_normal_n: float
    normal_n: float
    true_mm: float
    estimated_mm: float


class ForceBand(NamedTuple):
    """Ends of the band of an estimated force, (...) N."""

    least: Array
    most: Array


def force_band(interval: Array, answer: Array) -> ForceBand:
    """The band of a force from its interval, (..., 3) N, and the answer of the posterior, (...).

    The interval is given contact; where no contact is detected, the band begins at 0. NaN where the interval is.
    """
    least = np.where((answer == NOTHING) & np.isfinite(interval[..., 0]), 0.0, interval[..., 0])
    return ForceBand(least, interval[..., INTERVAL.index("most")])


@dataclass(frozen=True)
class ContactForces:
    """The contact force of F fingers over time, see `Recording.forces`; printed, it is a table of the last sample.

    ::

        data    true_transverse, transverse  (T, F) N, at right angles to the line from the base to the contact
                least, most                  (T, F) N, ends of its band, which holds the true one with 95 %
                true_closing, closing        (T, F) N, along -x of the base of the finger
                true_normal, normal          (T, F) N, across the finger in its plane, positive on the inner side
                true_location, location      (T, F) m along the finger from its base; NaN without contact

    NaN where a quantity is not known: nothing is estimated while a finger moves so fast that contact would be missed,
    or where no single force explains the readings.
    """

    data: "xr.Dataset"

    def at(self, time: float | None = None) -> list[FingerForce]:
        """The force on each finger at the sample nearest to a time, s; None: the last.

        Raises:
            InputError: if the time is not one of the recording.
        """
        times = self.data["time"].values
        nearest_time = float(times[-1]) if time is None else time
        if not times[0] <= nearest_time <= times[-1]:
            expected = f"must be from {times[0]:g} to {times[-1]:g} s, as recorded"
            raise InputError("forces", "time", time, expected)
        return self._sample_forces(int(np.argmin(np.abs(times - nearest_time))))

    def rows(self) -> list[FingerForce]:
        """The force on each finger at every sample."""
        return [row for sample in range(self.data.sizes["time"]) for row in self._sample_forces(sample)]

    def _sample_forces(self, sample: int) -> list[FingerForce]:
        data = self.data.isel(time=sample)
        return [self._row(data.isel(finger=finger)) for finger in range(data.sizes["finger"])]

    @staticmethod
    def _row(data: "xr.Dataset") -> FingerForce:
        values = {name: float(data[name]) for name in _VARIABLE_UNITS}
        forces = (value for name, value in values.items() if _VARIABLE_UNITS[name] == "N")
        locations = (1e3 * value for name, value in values.items() if _VARIABLE_UNITS[name] == "m")
        return FingerForce(str(data["finger"].values), float(data["time"]), *forces, *locations)

    def __str__(self) -> str:
        """Table of the forces at the last sample."""
        return forces_text(self.at())


def contact_forces(data: "xr.Dataset") -> ContactForces:
    """The contact forces in the signals of a recording.

    Raises:
        InputError: if no contact force was recorded, true or estimated.
    """
    import xarray as xr

    kinds = _TRUE_FORCE, _ESTIMATED_FORCE
    owners = dict.fromkeys(str(name).rpartition(".")[0] for name in data if str(name).rpartition(".")[2] in kinds)
    fingers = [owner for owner in owners if "." not in owner]  # others are further estimates, of `alongside`
    if not fingers:
        raise InputError("recording", "signal", f"{_TRUE_FORCE} or {_ESTIMATED_FORCE}", _NO_FORCE)
    finger_forces = [_finger_forces(data, finger) for finger in fingers]
    variables = {
        name: (("time", "finger"), np.stack([forces[name] for forces in finger_forces], axis=-1), {"units": unit})
        for name, unit in _VARIABLE_UNITS.items()
    }
    return ContactForces(xr.Dataset(variables, {"time": data["time"], "finger": fingers}))


_FORCE_NAMES = "true_transverse", "transverse", "least", "most", "true_closing", "closing", "true_normal", "normal"
_VARIABLE_UNITS = dict.fromkeys(_FORCE_NAMES, "N")
_VARIABLE_UNITS |= dict.fromkeys(("true_location", "location"), "m")


def _finger_forces(data: "xr.Dataset", finger: str) -> dict[str, Array]:
    """The variables of one finger, (T) each."""

    def signal(name: str) -> Array:
        full = f"{finger}.{name}"
        return data[full].values if full in data else np.full(data.sizes["time"], np.nan)

    interval = f"{finger}.transverse_force_interval"
    unknown = np.full(data.sizes["time"], np.nan)
    band = ForceBand(unknown, unknown)
    if interval in data:
        band = force_band(data[interval].values, signal("contact_answer"))
    true_closing, closing = unknown, unknown
    if f"{finger}.true_contact_force_world" in data and f"{finger}.X_WB" in data:
        true_closing = to_base(signal("X_WB"), signal("true_contact_force_world")) @ CLOSING
    if f"{finger}.contact_force_vector" in data:
        closing = signal("contact_force_vector") @ CLOSING
    contact_names = "true_contact_force", "contact_force", "true_contact_arc_length", "contact_arc_length"
    forces = signal(_TRUE_FORCE), signal(_ESTIMATED_FORCE), *band, true_closing, closing, *map(signal, contact_names)
    return dict(zip(_VARIABLE_UNITS, forces, strict=True))


def forces_text(rows: Sequence[FingerForce], estimator: str = "") -> str:
    """A table of forces at one time, without nan; `estimator` is the name of their estimator."""
    headings = "finger", "true force [N]", "at [mm]", "estimated [N]", "95 % band [N]", "at [mm]"
    forms = "", *[">"] * (len(headings) - 1)
    cells = [
        [
            row.finger,
            _value_text(row.true_transverse_n, ".2f"),
            _location_text(row.true_transverse_n, row.true_mm),
            _value_text(row.transverse_n, ".2f"),
            UNKNOWN if math.isnan(row.least_n) else f"{row.least_n:.2f} to {row.most_n:.2f}",
            _location_text(row.transverse_n, row.estimated_mm),
        ]
        for row in rows
    ]
    estimator_note = f", estimated by {estimator}" if estimator else ""
    title = f"Transverse contact forces at {rows[0].time_s:.2f} s{estimator_note}"
    text = table_text(headings, forms, cells, title)
    return text if estimator or any(math.isfinite(row.most_n) for row in rows) else f"{text}\n{_NO_ESTIMATE}"


def _value_text(value: float, form: str) -> str:
    return UNKNOWN if math.isnan(value) else f"{value:z{form}}"


def _location_text(force: float, location: float) -> str:
    return "no contact" if force == 0 else _value_text(location, ".0f")
