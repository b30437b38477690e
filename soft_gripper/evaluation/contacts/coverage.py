"""How often what `contact` states of a force is true, by where along the finger the force acts.

    python -m soft_gripper.evaluation.contacts.coverage

writes `contact_coverage.csv` and a figure into results/contact_coverage. Single contacts are computed by statics with
no friction, any friction and friction at the cone, and simulated with Drake. Two contacts and contacts spread over a
stretch of the finger are computed by statics.

Of some hundred contacts a share of 95 % has a standard error of 2 %, and the least of thousands of shares is far below.
So a tenth of the length with a share below CLEAR, or with fewer than FEWEST contacts that are detected, is counted once
more, on more contacts that are drawn anew.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.contact import STRADDLED, ContactShape
from soft_gripper.estimators.force_posterior import DETECTED, ContactPosterior
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.evaluation.contacts.dataset import (
    LAYOUTS,
    PEG_FRICTION,
    SIDES,
    Contacts,
    G,
    as_arrays,
    combined_friction,
    describe_borders,
    read_finger,
    run_contact,
)
from soft_gripper.evaluation.contacts.estimates import REALISTIC, Condition, disturbed_readings
from soft_gripper.evaluation.contacts.friction_cone import FORCES, PRESSURES, balanced, rubbing_contacts, rubbing_torque
from soft_gripper.files.csv_table import write_csv
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

PLACES = 0.1, 1.0  # of the length
ENOUGH = 92.0  # %, of the bar
CLEAR, AGAIN = 94.0, 1000  # %, below which a share is in doubt, and contacts that decide
FEWEST = 100  # contacts of which a share is stated
TABLE, FIGURE = "contact_coverage.csv", "contact_coverage"
_TENTHS = range(1, 10)


@dataclass(frozen=True)
class Conditions:
    """What is uncertain, and what the estimator assumes of it."""

    name: str
    assumed: Uncertainty
    noise: float = 0.0  # of the extension ratios
    youngs_modulus: str | None = None  # nominal, as a change
    realistic: bool = False  # sensors
    as_assumed: bool = False  # finger and pressure differ from the nominal ones by as much as is assumed


def conditions() -> list[Conditions]:
    """Those of the study."""
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=REALISTIC)))
    ideal = Uncertainty()
    return [
        Conditions("ideal sensors", ideal),
        Conditions("noise of 0.1 %", Uncertainty(reading=1e-3), noise=1e-3),
        Conditions("realistic sensors", uncertainty_of(errors), realistic=True),
        Conditions("stiffness 10 % wrong", Uncertainty(bend_per_pressure=0.1), youngs_modulus="+10 %"),
        Conditions("errors as assumed", ideal, noise=ideal.reading, as_assumed=True),
    ]


@dataclass(frozen=True)
class CoverageRow:
    """Contacts in one tenth of the length: the share of them, %, of which what is stated is true, and medians."""

    contacts: str
    condition: str
    sections: int
    borders: str  # mm from the base
    beyond: float  # share of the length at which the tenth begins; NaN for several contacts
    number: int
    detected_percent: float
    explained_percent: float  # by a single force; what follows is of these, but for the bound of several
    interval_percent: float
    set_percent: float
    bound_percent: float
    bound_beyond_percent: float  # of contacts beyond `nearest_contact`
    bound_several_percent: float
    place_percent: float  # of those detected
    width: float  # median of the length of the interval, divided by the force
    bound: float  # median, divided by the force
    bound_beyond: float
    bound_several: float


def estimated(layout: SensorLayout, contacts: Contacts, condition: Conditions, seed: int) -> ContactPosterior:
    """The posterior of every contact under a condition."""
    rng, assumed, pressure, q = np.random.default_rng(seed), condition.assumed, contacts.pressure, contacts.q
    if condition.as_assumed:
        pressure = pressure / (1 + assumed.bend_per_pressure * rng.standard_normal(pressure.shape))
        q = q * (1 + assumed.bend_per_pressure * rng.standard_normal((len(q), 1)))
        q = q + assumed.angle * rng.standard_normal(q.shape) + _straddling(contacts, rng)
    ratios = extension_ratios(layout, q)
    readings = layout.response.reading(ratios + condition.noise * rng.standard_normal(ratios.shape))
    if condition.realistic:
        errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=REALISTIC)))
        assert errors is not None
        readings = disturbed_readings(layout, contacts, errors, 1, 1).pressed[0]
    finger = Condition(condition.youngs_modulus).nominal_finger(layout.finger)
    nominal = SensorLayout(finger, layout.sections, borders=layout.borders)
    return ContactShape(nominal, assumed).posterior(readings, finger.pressure_torque(pressure), contacts.gravity)


def _straddling(contacts: Contacts, rng: np.random.Generator) -> Array:
    """By how much contacts turn the joints next to them that they straddle, (M, N) rad."""
    finger = contacts.finger
    nearest = np.abs(contacts.arc_length[:, None] - finger.joint_arc_lengths).argmin(axis=-1)
    torque = STRADDLED * contacts.force * rng.standard_normal(contacts.force.shape)
    turned: Array = (nearest[:, None] == np.arange(finger.segments)) * torque[:, None] / finger.stiffness
    return turned


def coverage_row(
    kind: str, condition: Conditions, layout: SensorLayout, beyond: float, contacts: Contacts, found: ContactPosterior
) -> CoverageRow:
    """The row of some contacts."""
    force, place = np.abs(contacts.force), contacts.arc_length
    detected, explained = found.probability > DETECTED, np.isfinite(found.force_set[:, 0])
    far = place > condition.assumed.nearest_contact * layout.finger.length
    low, _, high = found.force_interval.T
    bounds, (nearest, furthest) = found.force_bounds.T, found.arc_length_set.T
    shares = (
        (detected, np.ones_like(detected)),
        (explained, np.ones_like(detected)),
        ((low <= force) & (force <= high), explained),
        ((found.force_set[:, 0] <= force) & (force <= found.force_set[:, 1]), explained),
        (force <= bounds[0], explained),
        (force <= bounds[1], far & explained),
        (force <= bounds[2], far),
        ((nearest <= place) & (place <= furthest), detected & explained),
    )
    medians = (
        ((high - low) / force, explained),
        (bounds[0] / force, explained),
        (bounds[1] / force, far & explained),
        (bounds[2] / force, far),
    )
    return CoverageRow(
        *(kind, condition.name, layout.sections, describe_borders(layout), beyond, len(force)),
        *(100 * _of(np.mean, *share) for share in shares),
        *(_of(np.median, *median) for median in medians),
    )


def _of(statistic: Callable[[Array], float], values: Array, chosen: NDArray[np.bool_]) -> float:
    return float(statistic(values[chosen])) if chosen.any() else float("nan")


KINDS = "no friction", "any friction", "friction at the cone", "simulated"


def contacts_of(kind: str, number: int, seed: int, places: tuple[float, float] = PLACES) -> Contacts:
    """About `number` single contacts of one of KINDS."""
    if kind == "simulated":
        return as_arrays([run_contact(seed, i, PEG_FRICTION, places) for i in range(number)])
    i = KINDS.index(kind)
    share = (0.0, np.random.default_rng(seed).uniform(size=number), 1.0)[i]
    return rubbing_contacts(number, combined_friction(PEG_FRICTION), share, seed + i, places)


_KINDS_OF_SEVERAL = "two contacts", "a spread contact"
_APART, _POINTS = 0.15, 12  # of the length between two contacts, at least; forces of a spread contact


def several_contacts(number: int, seed: int) -> Iterator[tuple[str, Contacts]]:
    """About `number` of each kind beyond `nearest_contact`, on one side; force and place are the sum and its centre."""
    near = Uncertainty().nearest_contact
    for i, kind in enumerate(_KINDS_OF_SEVERAL):
        rng, finger = np.random.default_rng([seed, i]), read_finger()
        side = np.asarray(rng.choice(list(SIDES), number), dtype=str)
        sign = np.array([SIDES[one] for one in side])
        ends = np.sort(rng.uniform(near, 1, (number, 2)), axis=-1)
        shares = rng.uniform(0.2, 0.8, number)[:, None] * np.array([1.0, -1.0]) + np.array([0.0, 1.0])
        if i:
            ends, shares = ends @ _spread_out(), np.full((number, _POINTS), 1 / _POINTS)
        total, pressure = (np.array([rng.uniform(*ranges[one]) for one in side]) for ranges in (FORCES, PRESSURES))
        gravity = np.asarray(G * np.exp(2j * np.pi * rng.uniform(size=number)), dtype=complex)
        place, forces = finger.length * ends, (sign * total)[:, None] * shares
        rubs = combined_friction(PEG_FRICTION) * rng.uniform(-1, 1, forces.shape)
        kept = np.ptp(ends, axis=-1) > _APART
        place, forces, rubs = place[kept], forces[kept], rubs[kept]
        yield kind, _in_balance(finger, pressure[kept], gravity[kept], place, forces, rubs, side[kept])


def _spread_out() -> Array:
    """From two ends to points at equal distances between them, (2, _POINTS)."""
    along = np.linspace(0, 1, _POINTS)
    return np.array([1 - along, along])


def _in_balance(
    finger: Finger,
    pressure: Array,
    gravity: Planar,
    place: Array,
    forces: Array,
    rubs: Array,
    side: NDArray[np.str_],
) -> Contacts:
    section = finger.section(place)
    offset = np.where(forces > 0, section.inner_face, section.outer_face)

    def torque_at(q: Array) -> Array:
        each = zip(place.T, offset.T, forces.T, rubs.T, strict=True)
        torque: Array = sum((rubbing_torque(finger, q, *one) for one in each), np.zeros_like(q))
        return torque

    q, kept = balanced(finger, pressure, gravity, torque_at)
    total = forces.sum(axis=-1)
    center, unknown = (forces * place).sum(axis=-1) / total, np.zeros_like(total)
    values: tuple[Any, ...] = q, pressure, gravity, total, np.abs(total), center, torque_at(q), side, unknown, unknown
    return Contacts(*(value[kept] for value in values))


def in_doubt(row: Any, shares: Sequence[str], again: int) -> bool:
    """Whether a share of a row may be below ENOUGH by chance, or is one of too few; never without others to count."""
    few = located(row) < FEWEST < again * row.detected_percent / 100
    return again > 0 and (few or any(getattr(row, f"{share}_percent") < CLEAR for share in shares))


def located(row: Any) -> float:
    """The number of contacts that are detected."""
    return float(row.number * row.detected_percent / 100)


def _cases() -> Iterator[tuple[SensorLayout, Conditions]]:
    for sections, borders in LAYOUTS:
        layout = SensorLayout(read_finger(), sections, borders=borders)
        yield from ((layout, condition) for condition in conditions())


def _within(contacts: Contacts, i: int) -> NDArray[np.int_]:
    """The numbers of those in a tenth of the length; the last includes the tip."""
    tenth = np.minimum((10 * contacts.arc_length / contacts.finger.length).astype(int), _TENTHS[-1])
    return np.flatnonzero(tenth == i)


def _of_single(kind: str, number: int, seed: int, again: int) -> Iterator[CoverageRow]:
    """The rows of one of KINDS."""
    contacts = contacts_of(kind, number, seed)

    @cache
    def others(i: int) -> Contacts:
        drawn = contacts_of(kind, again, 1000 * seed + i, (i / 10, (i + 1) / 10))
        return drawn.at(_within(drawn, i))

    for layout, condition in _cases():
        found = estimated(layout, contacts, condition, seed)
        for i in _TENTHS:
            at, name = _within(contacts, i), (kind, condition, layout, i / 10)
            row = coverage_row(*name, contacts.at(at), ContactPosterior(*(values[at] for values in found)))
            if in_doubt(row, tuple(_PRINTED), again):
                row = coverage_row(*name, others(i), estimated(layout, others(i), condition, seed))
            yield row


def coverage_rows(
    number: int, seed: int, again: int = AGAIN, report: Callable[[str], object] = print
) -> list[CoverageRow]:
    """The rows of all contacts under all conditions; tenths in doubt are counted on `again` contacts instead."""
    rows: list[CoverageRow] = []
    for kind in KINDS:
        rows += _of_single(kind, number, seed, again)
        report(kind)
    for kind, contacts in several_contacts(number // 3, seed):
        for layout, condition in _cases():
            found = estimated(layout, contacts, condition, seed)
            rows.append(coverage_row(kind, condition, layout, float("nan"), contacts, found))
        report(f"{kind}: {len(contacts.force)}")
    return rows


_SHOWN = {"interval": "95 % interval", "set": "likelihood set", "bound": "upper bound", "place": "place, if detected"}
_LINES = dict(zip(_SHOWN, ("#0072b2", "#009e73", "#d55e00", "#cc79a7"), strict=True))


def coverage_figure(rows: Sequence[CoverageRow]) -> Figure:
    """Coverage of single contacts of all kinds together, a row of panels a layout; below, how wide the bounds are."""
    names, single = [condition.name for condition in conditions()], [row for row in rows if row.beyond == row.beyond]
    layouts = list(dict.fromkeys((row.sections, row.borders) for row in single))
    places = np.array(_TENTHS) / 10 + 0.05
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.5 * len(names), 8.4), layout="constrained")
        panels = figure.subplots(len(layouts) + 1, len(names), sharex=True, sharey="row", squeeze=False)
        for column, name in zip(panels.T, names, strict=True):
            column[0].set_title(name, fontsize="medium")
            for axes, layout in zip(column, layouts, strict=False):
                axes.axhline(ENOUGH, color="0.6", lw=0.8, ls="--")
                for field, label in _SHOWN.items():
                    shown = [_pooled(single, name, layout, i / 10, f"{field}_percent") for i in _TENTHS]
                    axes.plot(places, shown, color=_LINES[field], lw=1.4, marker="o", ms=2.5, label=label)
                axes.set(ylim=(79, 101), xlim=(0.1, 1))
            for layout, color in zip(layouts, (COLORS[1], COLORS[2], COLORS[4]), strict=True):
                for field, look in (("bound", "-"), ("bound_beyond", "--")):
                    shown = [_pooled(single, name, layout, i / 10, field) for i in _TENTHS]
                    column[-1].plot(places, shown, color=color, ls=look, lw=1.4)
            column[-1].set(yscale="log", xlabel="place of the force / length")
        for axes, (sections, borders) in zip(panels[:, 0], layouts, strict=False):
            axes.set_ylabel(f"{sections} sections, {borders} mm\ntrue [%]")
        panels[-1, 0].set_ylabel("upper bound / force, median")
        handles = [mpl.lines.Line2D([], [], color=color) for color in (COLORS[1], COLORS[2], COLORS[4])]
        handles += [mpl.lines.Line2D([], [], color="0.3", ls=look) for look in ("-", "--")]
        named = [f"{sections}: {borders} mm" for sections, borders in layouts]
        near = f"given beyond {Uncertainty().nearest_contact:g} of the length"
        panels[0, -1].legend(loc="lower right", frameon=False, fontsize="small")
        figure.legend(handles, [*named, "anywhere", near], loc="outside lower center", ncols=5, frameon=False)
    return figure


def _pooled(rows: Sequence[CoverageRow], name: str, layout: tuple[int, str], beyond: float, field: str) -> float:
    """The mean over all kinds of contacts of a tenth, weighted by their number."""
    chosen = [row for row in rows if (row.condition, row.sections, row.borders, row.beyond) == (name, *layout, beyond)]
    values, numbers = np.array([getattr(row, field) for row in chosen]), np.array([row.number for row in chosen])
    known = np.isfinite(values)
    return float(values[known] @ numbers[known] / numbers[known].sum()) if known.any() else float("nan")


_PRINTED = {"interval": "interval", "set": "set", "bound": "bound", "bound_beyond": "beyond", "place": "place"}


def least(rows: Sequence[Any], share: str) -> float:
    """The least of a share over some tenths, %; one of the place counts if enough contacts are detected."""
    counted = [row for row in rows if share != "place" or located(row) >= FEWEST]
    return float(np.nanmin([getattr(row, f"{share}_percent") for row in counted] or [np.nan]))


def print_coverage(rows: Sequence[CoverageRow]) -> None:
    """Prints the least coverage over the tenths of the length, and that of several contacts."""
    single = [row for row in rows if row.beyond == row.beyond]
    groups = list(dict.fromkeys((row.contacts, row.condition, row.sections, row.borders) for row in single))
    lines: list[list[str | float]] = []
    for group in groups:
        tenths = [row for row in single if (row.contacts, row.condition, row.sections, row.borders) == group]
        shares = [least(tenths, field) for field in _PRINTED]
        lines.append([*group[:2], f"{group[2]}: {group[3]}", min(row.number for row in tenths), *shares])
    print("least coverage of a tenth of the length [%]")
    _print_lines([["contacts", "condition", "sections", "of", *_PRINTED.values()], *lines])
    lines = [
        [
            *(row.contacts, row.condition, f"{row.sections}: {row.borders}", row.number),
            *(row.explained_percent, row.set_percent, row.bound_beyond_percent, row.bound_several_percent),
            row.bound_several,
        ]
        for row in rows
        if row.beyond != row.beyond
    ]
    titles: list[str | float] = ["one explains", "set", "beyond", "several", "bound / force"]
    print("several contacts: coverage of the sum of their forces [%]")
    _print_lines([["contacts", "condition", "sections", "of", *titles], *lines])


def _print_lines(lines: Sequence[Sequence[str | float]]) -> None:
    for line in lines:
        first, rest = line[:3], [cell if isinstance(cell, str) else f"{cell:.4g}" for cell in line[3:]]
        print("".join(f"{cell:<22}" for cell in first) + "".join(f"{cell:>14}" for cell in rest))


def main(number: int = 1100, seed: int = 1, again: int = AGAIN, out: str = "results/contact_coverage") -> None:
    """Writes table and figure, and prints a summary."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    rows = coverage_rows(number, seed, again)
    write_csv(folder / TABLE, rows)
    save_figure(coverage_figure(rows), folder / FIGURE)
    print_coverage(rows)


if __name__ == "__main__":
    main()
