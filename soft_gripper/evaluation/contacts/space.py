"""Contacts on every side of a finger that leaves its plane: what `contact` estimates, and how often it is true.

    python -m soft_gripper.evaluation.contacts.space

writes `contacts_in_space.csv` and a figure into results/contacts_in_space. Forces on the four faces are computed by
statics, with no friction, any friction and friction at the cone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ContactForce, SpatialContact, SpatialShape
from soft_gripper.estimators.force_posterior import DETECTED, ContactPosterior
from soft_gripper.estimators.spatial_contact import SpatialContactShape
from soft_gripper.estimators.spatial_estimator import Places
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.evaluation.contacts.coverage import ENOUGH, Conditions, conditions, in_doubt, least
from soft_gripper.evaluation.contacts.dataset import PEG_FRICTION, G, combined_friction, read_finger
from soft_gripper.evaluation.contacts.estimates import REALISTIC, Condition
from soft_gripper.files.csv_table import write_csv
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import Loads, posture, spatial_chain, torques, weights
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from soft_gripper.runs.executor import open_executor
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import disturb

WAYS = ("bending", "sideways", "twist")
LAYOUT, SECTIONS = "four_faces_and_diagonal", (2, 4)
PLACES = 0.1, 0.99  # of the length
FORCES, PRESSURES = (0.1, 1.0), (0.0, 120e3)  # N, Pa
ACROSS = 0.8  # of the width of a face, within which forces act
MOST_BEND = 2.6  # rad, of the whole finger
TABLE, FIGURE, OUT = "contacts_in_space.csv", "contacts_in_space", "results/contacts_in_space"
AGAIN = 400  # contacts that decide a share in doubt
SMOOTH = "no friction"
_TENTHS = range(1, 10)
_REPETITIONS, _STEP, _BALANCED = 200, 0.6, 1e-8  # rad
_HELD = 50  # samples of a motion into the contact, and of holding it


class SpatialContacts(NamedTuple):
    """M contacts in balance, each one force on a face."""

    q: Array  # (M, D) joint positions, way after way
    pressure: Array  # (M,) Pa
    gravity: Array  # (M, 3) m/s^2 in B
    arc_length: Array  # (M,) m
    normal_force: Array  # (M,) N
    force: Array  # (M, 3) N in B, friction included

    def at(self, rows: NDArray[np.int_] | NDArray[np.bool_]) -> "SpatialContacts":
        """Some of them."""
        return SpatialContacts(*(values[rows] for values in self))


@cache
def finger_in_space() -> Finger:
    """The shipped finger, which yields sideways and in twist as well."""
    return replace(read_finger(), yields=WAYS)


def contacts_in_space(
    number: int, friction: Array | float, seed: int, places: tuple[float, float] = PLACES
) -> SpatialContacts:
    """About `number` contacts at random places on the four faces, under random pressures and weights.

    `friction` is the coefficient, one for all or (number); its direction on the face is random. Contacts that bend the
    finger by more than MOST_BEND, or for which no balance is found, are left out.
    """
    rng, finger = np.random.default_rng(seed), finger_in_space()
    s, joints = finger.length * rng.uniform(*places, number), finger.joint_arc_lengths
    link = np.searchsorted(joints, s)
    angle, turn = rng.integers(4, size=number) * np.pi / 2, rng.uniform(0, 2 * np.pi, number)
    normal = np.stack([np.cos(angle), np.sin(angle), np.zeros(number)], axis=-1).round()
    across = np.stack([-normal[:, 1], normal[:, 0], np.zeros(number)], axis=-1)
    section = finger.section(s)
    depth, middle = (section.inner_face - section.outer_face) / 2, (section.inner_face + section.outer_face) / 2
    half = np.stack([depth, np.broadcast_to(section.width / 2, s.shape), np.zeros(number)], axis=-1)
    place = (normal + rng.uniform(-ACROSS, ACROSS, number)[:, None] * across) * half
    place[:, 0] += middle
    place[:, 2] += s - np.append(0.0, joints)[link]
    along = np.array([0.0, 0.0, 1.0])
    rubbing = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * along
    size = rng.uniform(*FORCES, number)
    local = size[:, None] * (np.broadcast_to(friction, number)[:, None] * rubbing - normal)
    direction = rng.standard_normal((number, 3))
    gravity = G * rng.uniform(size=number)[:, None] * direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    pressure = rng.uniform(*PRESSURES, number)
    q, force = np.empty((number, 3 * finger.segments)), np.empty((number, 3))
    for i in range(finger.segments + 1):
        at = link == i
        q[at], force[at] = _in_balance(finger, i, pressure[at], gravity[at], place[at], local[at])
    kept = np.isfinite(q).all(axis=-1) & (np.abs(q[:, : finger.segments]).sum(axis=-1) < MOST_BEND)
    return SpatialContacts(q, pressure, gravity, s, size, force).at(kept)


def _in_balance(
    finger: Finger, link: int, pressure: Array, gravity: Array, place: Array, local: Array
) -> tuple[Array, Array]:
    """Joint positions, (M, D), and forces in B, (M, 3), under forces that turn with the link; NaN without balance."""
    chain = spatial_chain(finger)
    own, frame = weights(finger, chain, gravity), int(chain.beyond(np.array(link)))
    driving, stiffness = chain.spread({"bending": finger.pressure_torque(pressure)}), chain.spread(finger.stiffnesses)
    points = np.concatenate([np.broadcast_to(own.points, own.forces.shape), place[:, None]], axis=1)
    q, left, still = driving / stiffness, np.full(driving.shape, np.inf), np.zeros((*points.shape[:2], 3))
    for _ in range(_REPETITIONS):
        at = posture(chain, q)
        force = (at.rotations[:, frame] @ local[..., None])[..., 0]
        loads = Loads(np.append(own.frames, frame), points, np.concatenate([own.forces, force[:, None]], axis=1), still)
        left = (driving + torques(at, loads)) / stiffness - q
        q = q + _STEP * left
    q[np.abs(left).max(axis=-1) > _BALANCED] = np.nan
    return q[:, np.argsort(chain.places(WAYS))], force


@dataclass(frozen=True)
class SpatialRow:
    """Contacts in one tenth of the length: the share of them, %, of which what is stated is true, and median errors."""

    contacts: str
    condition: str
    sections: int
    beyond: float  # share of the length at which the tenth begins; NaN for all beyond a third
    number: int
    detected_percent: float
    explained_percent: float  # by a single force; what follows is of these
    interval_percent: float
    set_percent: float
    bound_percent: float
    place_percent: float  # of those detected
    force_percent: float  # median errors, of all contacts between the same ends: of the magnitude
    direction_degrees: float
    location_percent: float  # of the length
    tip_mm: float
    tip_gaussian_mm: float  # of `gaussian`
    bound: float  # median, divided by the force


def read_by(layout: MeasurementModel, contacts: SpatialContacts, condition: Conditions, seed: int) -> Array:
    """Readings of the contacts, (M, R)."""
    rng = np.random.default_rng(seed)
    if condition.realistic:
        errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=REALISTIC)))
        assert errors is not None
        motion = np.append(np.linspace(0, 1, _HELD), np.ones(_HELD))[:, None, None] * contacts.q
        ratios = disturb(errors, 1 + layout.predict(motion), 0.05, rng)[-1]
        return np.asarray(layout.response.reading(ratios))
    exact = layout.predict(contacts.q)
    return np.asarray(layout.response.reading(1 + exact + condition.noise * rng.standard_normal(exact.shape)))


class Estimated(NamedTuple):
    """What is estimated of M contacts."""

    shape: SpatialShape
    gaussian: Array  # (M, D), joint positions
    known: ContactPosterior


class _Given(NamedTuple):
    """To the estimators of M contacts."""

    layout: MeasurementModel
    samples: tuple[Array, Array, Array]  # readings, driving torque and gravity


def _given(sections: int, contacts: SpatialContacts, condition: Conditions, seed: int) -> _Given:
    rng, finger, assumed = np.random.default_rng(seed), finger_in_space(), condition.assumed
    config = SensorConfig(layout=LAYOUT, sections=sections)
    pressure = contacts.pressure
    if condition.as_assumed:
        pressure = pressure / (1 + assumed.bend_per_pressure * rng.standard_normal(pressure.shape))
        contacts = contacts._replace(q=contacts.q + assumed.angle * rng.standard_normal(contacts.q.shape))
    readings = read_by(sensor_layout(finger, config), contacts, condition, seed)
    nominal = Condition(condition.youngs_modulus).nominal_finger(finger)
    driving = np.zeros(contacts.q.shape)
    driving[:, : finger.segments] = nominal.pressure_torque(pressure)
    return _Given(sensor_layout(nominal, config), (readings, driving, contacts.gravity))


def estimated(sections: int, contacts: SpatialContacts, condition: Conditions, seed: int) -> Estimated:
    """Of all contacts under a condition, with sensors in some sections."""
    layout, samples = _given(sections, contacts, condition, seed)
    contact = SpatialContactShape(layout, condition.assumed)
    gaussian = SpatialGaussianShape(layout, condition.assumed)(*samples)
    return Estimated(contact(*samples), gaussian.q, contact.posterior(*samples).known)


def spatial_row(
    kind: str, condition: Conditions, sections: int, beyond: float, contacts: SpatialContacts, found: Estimated
) -> SpatialRow:
    """The row of some contacts."""
    contact, known, length = found.shape.contact, found.known, finger_in_space().length
    assert contact is not None
    force, true, place = contact.force, contacts.force, contacts.arc_length
    size, true_size = np.linalg.norm(force, axis=-1), np.linalg.norm(true, axis=-1)
    cosine = np.clip((force * true).sum(axis=-1) / np.maximum(size * true_size, 1e-12), -1, 1)
    touched, every = size > 0, np.ones(len(size), dtype=bool)
    medians = (
        (100 * np.abs(size / true_size - 1), every),
        (np.degrees(np.arccos(cosine)), touched),
        (100 * np.abs(contact.across.arc_length - place) / length, touched),
        (1e3 * _tip_distance(found.shape.q, contacts.q), every),
        (1e3 * _tip_distance(found.gaussian, contacts.q), every),
        (known.force_bounds[:, 0] / contacts.normal_force, np.isfinite(known.force_set[:, 0])),
    )
    shares = _true_percent(contacts, known)
    return SpatialRow(
        *(kind, condition.name, sections, beyond, len(place)),
        *(shares[name] for name in _SHARES),
        *(_of(np.median, *median) for median in medians),
    )


_SHARES = tuple(f"{name}_percent" for name in ("detected", "explained", "interval", "set", "bound", "place"))


def _true_percent(contacts: SpatialContacts, known: ContactPosterior) -> dict[str, float]:
    """The shares of a row."""
    pressing, place = contacts.normal_force, contacts.arc_length
    low, _, high = known.force_interval.T
    detected, explained = known.probability > DETECTED, np.isfinite(known.force_set[:, 0])
    (smallest, most), (nearest, furthest) = known.force_set.T, known.arc_length_set.T
    shares = (
        (detected, np.ones_like(detected)),
        (explained, np.ones_like(detected)),
        ((low <= pressing) & (pressing <= high), explained),
        ((smallest <= pressing) & (pressing <= most), explained),
        (pressing <= known.force_bounds[:, 0], explained),
        ((nearest <= place) & (place <= furthest), detected & explained),
    )
    return {name: 100 * _of(np.mean, *share) for name, share in zip(_SHARES, shares, strict=True)}


def _tip_distance(found: Array, true: Array) -> Array:
    places = Places(finger_in_space(), WAYS)
    return np.asarray(np.linalg.norm((places(found)[0] - places(true)[0])[:, -1], axis=-1))


KINDS = SMOOTH, "any friction", "friction at the cone"


def contacts_of(kind: str, number: int, seed: int, places: tuple[float, float] = PLACES) -> SpatialContacts:
    """About `number` contacts of one of KINDS."""
    i, rng = KINDS.index(kind), np.random.default_rng(seed)
    friction = combined_friction(PEG_FRICTION) * np.array((0.0, rng.uniform(size=number), 1.0)[i])
    return contacts_in_space(number, friction, seed + i, places)


def rows_of_kind(kind: str, number: int, seed: int, again: int) -> list[SpatialRow]:
    """The rows of a kind of contacts under all conditions: every tenth of the length, and all beyond a third."""
    contacts, rows = contacts_of(kind, number, seed), []
    share = contacts.arc_length / finger_in_space().length

    @cache
    def others(i: int) -> SpatialContacts:
        return contacts_of(kind, again, 1000 * seed + i, (i / 10, min((i + 1) / 10, PLACES[1])))

    for sections in SECTIONS:
        for condition in conditions():
            name, found = (kind, condition, sections), estimated(sections, contacts, condition, seed)
            for i in _TENTHS:
                at = (i / 10 <= share) & (share < (i + 1) / 10)
                row = spatial_row(*name, i / 10, contacts.at(at), _part(found, at))
                if in_doubt(row, tuple(_SHOWN), again):
                    row = _counted_again(row, condition, others(i), seed)
                rows.append(row)
            far = share > 1 / 3
            rows.append(spatial_row(*name, float("nan"), contacts.at(far), _part(found, far)))
    return rows


def _counted_again(row: SpatialRow, condition: Conditions, contacts: SpatialContacts, seed: int) -> SpatialRow:
    """The row with shares of other contacts."""
    layout, samples = _given(row.sections, contacts, condition, seed)
    known = SpatialContactShape(layout, condition.assumed).posterior(*samples).known
    shares: dict[str, Any] = {"number": len(contacts.arc_length), **_true_percent(contacts, known)}
    return replace(row, **shares)


def _of(statistic: Callable[[Array], float], values: Array, chosen: NDArray[np.bool_]) -> float:
    return float(statistic(values[chosen])) if chosen.any() else float("nan")


def _part(found: Estimated, at: NDArray[np.bool_]) -> Estimated:
    shape, contact = found.shape, found.shape.contact
    assert contact is not None
    across, rest = ContactForce(*(values[at] for values in contact.across)), (values[at] for values in contact[1:])
    known = ContactPosterior(*(values[at] for values in found.known))
    return Estimated(
        SpatialShape(shape.q[at], shape.covariance[at], SpatialContact(across, *rest)), found.gaussian[at], known
    )


_SHOWN = {
    "interval": "95 % interval",
    "set": "likelihood set",
    "bound": "upper bound",
    "place": "location, if detected",
}
_LINES = dict(zip(_SHOWN, ("#0072b2", "#009e73", "#d55e00", "#cc79a7"), strict=True))
_ERRORS = {
    "force_percent": "magnitude [%]",
    "direction_degrees": "direction [degrees]",
    "location_percent": "location [% of the length]",
}


def spatial_figure(rows: Sequence[SpatialRow]) -> Figure:
    """Coverage of all kinds of contacts together, a row of panels a layout; below, median errors without friction."""
    names = [condition.name for condition in conditions()]
    tenths = [row for row in rows if row.beyond == row.beyond]
    places = np.array(_TENTHS) / 10 + 0.05
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.5 * len(names), 2.1 * (len(SECTIONS) + len(_ERRORS))), layout="constrained")
        panels = figure.subplots(len(SECTIONS) + len(_ERRORS), len(names), sharex=True, sharey="row")
        for column, name in zip(panels.T, names, strict=True):
            column[0].set_title(name, fontsize="medium")
            of_name = [row for row in tenths if row.condition == name]
            for axes, sections in zip(column, SECTIONS, strict=False):
                axes.axhline(ENOUGH, color="0.6", lw=0.8, ls="--")
                for field, label in _SHOWN.items():
                    shown = [_pooled(of_name, sections, i / 10, f"{field}_percent") for i in _TENTHS]
                    axes.plot(places, shown, color=_LINES[field], lw=1.4, marker="o", ms=2.5, label=label)
                axes.set(ylim=(79, 101), xlim=(0.1, 1))
            smooth = [row for row in of_name if row.contacts == SMOOTH]
            for axes, field in zip(column[len(SECTIONS) :], _ERRORS, strict=True):
                for sections, color in zip(SECTIONS, (COLORS[1], COLORS[2]), strict=True):
                    shown = [getattr(row, field) for row in smooth if row.sections == sections]
                    axes.plot(places, shown, color=color, lw=1.4, label=f"{sections} sections")
                axes.set(yscale="log")
            column[-1].set(xlabel="place of the force / length")
        for axes, sections in zip(panels[:, 0], SECTIONS, strict=False):
            axes.set_ylabel(f"{sections} sections\ntrue [%]")
        for axes, title in zip(panels[len(SECTIONS) :, 0], _ERRORS.values(), strict=True):
            axes.set_ylabel(title)
        panels[0, -1].legend(loc="lower right", frameon=False, fontsize="small")
        panels[-1, -1].legend(frameon=False, fontsize="small")
    return figure


def _pooled(rows: Sequence[SpatialRow], sections: int, beyond: float, field: str) -> float:
    """The mean over all kinds of contacts of a tenth, weighted by their number."""
    chosen = [row for row in rows if (row.sections, row.beyond) == (sections, beyond)]
    values, numbers = np.array([getattr(row, field) for row in chosen]), np.array([row.number for row in chosen])
    known = np.isfinite(values)
    return float(values[known] @ numbers[known] / numbers[known].sum()) if known.any() else float("nan")


def print_rows(rows: Sequence[SpatialRow]) -> None:
    """Prints the least coverage of a tenth of the length, and median errors beyond a third of it."""
    print(f"{'':<46}{'least coverage of a tenth [%]':>40}{'median errors beyond a third':>44}")
    titles = *(f"{name}" for name in _SHOWN), "force %", "degrees", "place %", "tip mm", "gaussian"
    print(f"{'contacts':<22}{'condition':<22}{'':<2}" + "".join(f"{title:>10}" for title in titles))
    for row in rows:
        if row.beyond == row.beyond:
            continue
        group = row.contacts, row.condition, row.sections
        tenths = [
            each
            for each in rows
            if each.beyond == each.beyond and group == (each.contacts, each.condition, each.sections)
        ]
        shares = [least(tenths, field) for field in _SHOWN]
        errors = row.force_percent, row.direction_degrees, row.location_percent, row.tip_mm, row.tip_gaussian_mm
        print(
            f"{row.contacts:<22}{row.condition:<22}{row.sections:<2}"
            + "".join(f"{x:>10.3g}" for x in (*shares, *errors))
        )


def main(number: int = 1000, seed: int = 1, jobs: int = 2, again: int = AGAIN, out: str = OUT) -> None:
    """Writes table and figure, and prints a summary."""
    folder, count = Path(out), len(KINDS)
    folder.mkdir(parents=True, exist_ok=True)
    with open_executor(jobs) as executor:
        of_kinds = executor.map(rows_of_kind, KINDS, [number] * count, [seed] * count, [again] * count)
        rows = [row for of_kind in of_kinds for row in of_kind]
    write_csv(folder / TABLE, rows)
    save_figure(spatial_figure(rows), folder / FIGURE)
    print_rows(rows)


if __name__ == "__main__":
    main()
