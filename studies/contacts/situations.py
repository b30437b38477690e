"""Situations in which a user meets contacts, and what `contact` states of the contacts in them.

By statics: single contacts at rest with any friction, sliding ones, pairs, contacts spread along the finger, a plant of
more segments than the nominal finger, a plant that leaves the plane under an estimator that does not know it, and
contacts in space. Simulated: a finger that presses on a peg, at rest and shortly after steps of pressure, and an arm
that carries a box.

The nominal model is exact, and declared to be; or stiffness and pressure are wrong, by up to 10 and 2 %, which either
is declared or not: the uncertainty is the default one then. In DIFFERENCES the finger differs from the nominal one, or
the scene from the default uncertainty, in a way that this does not declare.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.batches import LazyArray
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import softened
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors, disturb
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import REALISTIC, Condition, preset_errors
from studies.contacts.found_contact import FoundContact, driving_torque
from studies.contacts.statics import (
    FRICTION,
    contacts_in_space,
    finger_in_space,
    rubbing_contacts,
    several_contacts,
)
from studies.robustness.plants import RUBBER

MOST_FRICTION = 1.0  # of sliding contacts
FINER = 48  # segments of a plant under a nominal finger of 12
STRONG, NEAR = {"inner": (2.0, 5.0), "outer": (2.0, 5.0)}, (0.1, 1 / 3)  # N; fractions of the length
ROUGH = 1.3  # friction, above the 0.9 of the default uncertainty
BORDER_SHIFT = 1 / 12  # of the length, 10 mm
STIFFNESS, PRESSURE = (-10, -5, 0, 5, 10), 0.02  # %, errors of the nominal one; share, the largest error
MODELS = "exact, declared", "wrong, defaults", "wrong, called exact"
NOMINAL = "as simulated, defaults"
_MOVED, _PERIOD = 100, 0.05  # samples of a motion into the contact and of holding it, s between them


class Case(NamedTuple):
    """Sensors and nominal model of an estimator."""

    sections: int
    realistic: bool
    model: str = MODELS[0]

    @property
    def exact(self) -> bool:
        """Whether stiffness and pressure are the nominal ones."""
        return self.model in (MODELS[0], NOMINAL)

    @property
    def errors(self) -> StrainErrors | None:
        return preset_errors(REALISTIC if self.realistic else None)

    @property
    def assumed(self) -> Uncertainty:
        found = uncertainty_of(self.errors)
        return found if self.model in (MODELS[1], NOMINAL) else replace(found, bend_per_pressure=EXACT)

    @property
    def sensors(self) -> str:
        """In one word."""
        return REALISTIC if self.realistic else "ideal"


class Stated(NamedTuple):
    """M contacts, and what is stated of them; NaN where nothing is."""

    force: Array  # (M) N, true, absolute, across the face; of several the sum
    place: Array  # (M) share of the length, true
    estimated_force: Array  # (M) N
    estimated_place: Array  # (M)
    degrees: Array  # (M) between the true force and the estimated one; NaN in the plane
    probability: Array  # (M)
    interval: Array  # (M, 3) N
    bounds: Array  # (M, 3) N
    places: Array  # (M, 2) shares of the length
    transverse: Array  # (M) N, the true transverse force; of several, taken to press where their centre is
    estimated_transverse: Array  # (M) N
    transverse_std: Array  # (M) N
    transverse_interval: Array  # (M, 3) N

    def at(self, rows: NDArray[np.bool_]) -> "Stated":
        """Some of them."""
        return Stated(*(values[rows] for values in self))


def joined(parts: list[Stated]) -> Stated:
    """All contacts of several."""
    return Stated(*(np.concatenate(values) for values in zip(*parts, strict=True)))


class Statics(NamedTuple):
    """Contacts by statics of a finger, and the nominal finger and sensors, which by default know of bending alone."""

    contacts: Callable[..., Contacts]  # of a number and a seed, and of ranges of `forces` in DIFFERENCES
    nominal: Callable[[], Finger] = read_finger
    layout: str = "sides"
    border_shift: float = 0.0  # fraction of the length by which the middle border lies beyond the nominal one


def _sliding(number: int, seed: int) -> Contacts:
    """Contacts at the edge of a cone of up to MOST_FRICTION."""
    cone = np.random.default_rng(seed).uniform(0.2, MOST_FRICTION, number)
    return rubbing_contacts(number, seed, cone, 1.0)


def _of_plant_in_space(number: int, seed: int, faces: int) -> Contacts:
    friction = FRICTION * np.random.default_rng(seed).uniform(size=number)
    return contacts_in_space(number, friction, seed, faces=faces)


def graded(change: float) -> Finger:
    """The shipped finger, stiffer by this fraction at the base and softer by it at the tip, and linear between."""
    finger = read_finger()
    base, tip = (softened(finger, 1 / (1 + part)) for part in (change, -change))
    return replace(finger, base=base.base, tip=tip.tip)


STATICS = {
    "at rest": Statics(rubbing_contacts),
    "sliding": Statics(_sliding),
    "two contacts": Statics(lambda number, seed: several_contacts(number, FRICTION, seed)),
    "a spread contact": Statics(lambda number, seed: several_contacts(number, FRICTION, seed, spread=True)),
    "a plant of 48 segments": Statics(partial(rubbing_contacts, finger=lambda: replace(read_finger(), segments=FINER))),
    "a plant in space": Statics(lambda number, seed: _of_plant_in_space(number, seed, faces=2)),
    "in space": Statics(
        lambda number, seed: _of_plant_in_space(number // 2, seed, faces=4), finger_in_space, "four_faces_and_diagonal"
    ),
}
DIFFERENCES = {
    "none": Statics(rubbing_contacts),
    "stiffness +5 % at the base, -5 % at the tip": Statics(partial(rubbing_contacts, finger=partial(graded, 0.05))),
    "stiffness -10 % at the base, +10 % at the tip": Statics(partial(rubbing_contacts, finger=partial(graded, -0.10))),
    "a border between sections 10 mm off": Statics(rubbing_contacts, border_shift=BORDER_SHIFT),
    "forces of 2 to 5 N before a third of the length": Statics(partial(rubbing_contacts, places=NEAR, forces=STRONG)),
    "sliding with friction of 1.3": Statics(partial(rubbing_contacts, friction=ROUGH, share=1.0)),
    "a neo-Hookean plant": Statics(partial(rubbing_contacts, finger=lambda: RUBBER.finger(read_finger()))),
}
PEG, ARM = ("peg, at rest", "peg, after a step"), ("carried by an arm",)
_contacts = cache(lambda make, number, seed: make(number, seed))  # the same for all cases


def drawn(situation: Statics, case: Case, number: int, seed: int) -> Stated:
    """Statements about contacts by statics."""
    contacts, rng = _contacts(situation.contacts, number, seed), np.random.default_rng(seed)
    seen, config = situation.nominal(), SensorConfig(sections=case.sections, layout=situation.layout)
    true_config = config
    if situation.border_shift:
        borders = np.arange(1, case.sections) / case.sections
        borders[len(borders) // 2] += situation.border_shift
        true_config = replace(config, borders=borders.tolist())
    layout = sensor_layout(replace(seen, segments=contacts.finger.segments), true_config)
    readings = _read(layout, contacts.q, case, rng)
    measured, parts = _wrong(case, len(contacts.q), rng)
    found = [
        _stated_of(contacts.at(rows), seen, condition, config, case.assumed, readings[rows], measured[rows])
        for condition, rows in parts
    ]
    return joined(found)


def _read(layout: MeasurementModel, q: Array, case: Case, rng: np.random.Generator) -> Array:
    """Readings of postures, (M, D), into which the finger has moved, by sensors that see its first ways alone."""
    q = q[:, : len(layout.straight)]
    if case.errors is None:
        return layout.read(q)
    motion = np.clip(np.linspace(0, 2, _MOVED), 0, 1)[:, None, None] * q
    return np.asarray(layout.response.reading(disturb(case.errors, 1 + layout.predict(motion), _PERIOD, rng)[-1]))


def _wrong(case: Case, number: int, rng: np.random.Generator) -> tuple[Array, list[tuple[Condition, NDArray[np.int_]]]]:
    """Measured over true pressure, and the contacts for each nominal stiffness."""
    if case.exact:
        return np.ones(number), [(Condition(), np.arange(number))]
    stiffness = rng.integers(len(STIFFNESS), size=number)
    conditions = [Condition(f"{percent:+d} %" if percent else None) for percent in STIFFNESS]
    parts = [(each, np.flatnonzero(stiffness == i)) for i, each in enumerate(conditions)]
    return 1 + PRESSURE * rng.uniform(-1, 1, number), [(each, at) for each, at in parts if len(at)]


def _stated_of(
    contacts: Contacts,
    seen: Finger,
    condition: Condition,
    config: SensorConfig,
    assumed: Uncertainty,
    readings: Array,
    measured: Array,
) -> Stated:
    """Estimates of contacts whose readings and pressures, `measured` over the true ones, are known."""
    layout = sensor_layout(condition.nominal_finger(seen), config)
    estimator = ContactShape(layout, assumed)
    given = readings, driving_torque(layout.finger, layout.deformations, measured * contacts.pressure), contacts.gravity
    contact = estimator(*given).contact
    assert contact is not None
    transverse = contacts.transverse_force, contact.transverse_force, contact.transverse_force_std
    found = FoundContact.of(contact, contacts, layout.deformations != ("bending",))
    return _stated(
        contacts.normal_force,
        contacts.arc_length,
        found.force,
        found.arc_length,
        estimator.posterior(*given),
        found.degrees,
        transverse,
    )


def _stated(
    force: Array,
    place: Array,
    estimated: Array,
    estimated_place: Array,
    known: ContactPosterior,
    degrees: Array,
    transverse: tuple[Array | None, ...],
) -> Stated:
    """From places in m, and true, estimated and standard deviation of the transverse force; forces are absolute."""
    length = read_finger().length
    true, estimate, std = (np.asarray(values) for values in transverse)
    return Stated(
        force=force,
        place=place / length,
        estimated_force=np.abs(estimated),
        estimated_place=estimated_place / length,
        degrees=degrees,
        probability=known.probability,
        interval=known.force_interval,
        bounds=known.force_bounds,
        places=known.arc_length_set / length,
        transverse=true,
        estimated_transverse=estimate,
        transverse_std=std,
        transverse_interval=known.transverse_force_interval,
    )


HELD = 0.5  # s, of every step of pressure
_STEPS, _AFTER = 7, (0.05, 0.1, 0.15, 0.2, 0.25)  # s after a step
_LEAST_FORCE, _ACCELERATED = 0.05, 0.5  # N, m/s^2
_NEAREST, _GAP = 0.15, 6e-3  # of the length; m, between finger and peg at the tip, at most


def pressed(case: Case, number: int, seed: int) -> dict[str, Stated]:
    """Statements about a finger that presses on a peg, in `number` runs."""
    found: dict[str, list[Stated]] = {situation: [] for situation in PEG}
    for i in range(number):
        rng = np.random.default_rng([seed, i])
        share = rng.uniform(_NEAREST, 0.97)
        x, z = -0.0245 + _GAP * share * rng.uniform(), 0.2 - share * read_finger().length
        steps = np.round(rng.uniform(20e3, 150e3, _STEPS), 1).tolist()
        changes = _changes(case, rng) | {
            "pressure.settle": HELD - 0.1,
            "pressure.hold_samples": 10,
            "pressure.steps": {"all": [0.0], "left_finger": steps},
            "models.1.X_PC.translation": [x, 0, z],
        }
        recording = simulate(changed_scenario("obstructed_inside", changes))
        begins = HELD * np.arange(_STEPS)[:, None]
        for situation, after in zip(PEG, ([HELD - 0.01], _AFTER), strict=True):
            rows = np.round((begins + after).ravel() / 0.01).astype(int)
            found[situation].append(_recorded(recording, "left_finger", rows))
    return {situation: joined(parts) for situation, parts in found.items()}


def carried(case: Case, number: int, seed: int) -> dict[str, Stated]:
    """Statements about two fingers that hold a box while their arm accelerates, in `number` runs."""
    found = []
    for i in range(number):
        rng = np.random.default_rng([seed, i])
        mass = {"models.3.mass": rng.uniform(0.03, 0.06)}
        recording = simulate(changed_scenario("pick_and_place_box", _changes(case, rng) | mass))
        for finger in ("left_finger", "right_finger"):
            place = np.asarray(recording[f"{finger}.X_WB"])[:, :, 3]
            rate = np.gradient(np.gradient(place, 0.01, axis=0), 0.01, axis=0)
            moving = np.flatnonzero(np.linalg.norm(rate, axis=-1) > _ACCELERATED)
            found.append(_recorded(recording, finger, moving[:: max(len(moving) // 100, 1)]))
    return {ARM[0]: joined(found)}


def _changes(case: Case, rng: np.random.Generator) -> dict[str, Any]:
    """Changes of a scenario by dotted keys."""
    changes = {"estimator.type": "contact", "sensor.sections": case.sections, "sensor.seed": rng.integers(2**31)}
    if case.realistic:
        changes["sensor.errors.preset"] = REALISTIC
    if case.model != MODELS[1]:
        changes["estimator.uncertainty"] = vars(case.assumed)
    if not case.exact:
        stiffness, changes["pressure.leaks"] = rng.choice(STIFFNESS), {"all": PRESSURE * rng.uniform()}
        if stiffness:
            changes["nominal.finger.youngs_modulus"] = f"{stiffness:+d} %"
    return changes


def _recorded(recording: Recording, finger: str, rows: NDArray[np.int_]) -> Stated:
    def of(name: str) -> Array:
        values = np.asarray(recording[f"{finger}.{name}"])[rows]
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    later = {
        "interval": "contact_force_interval",
        "bounds": "contact_force_bounds",
        "transverse": "transverse_force_interval",
    }
    fields: dict[str, Any] = {field: of(f"contact_{field}") for field in ContactPosterior._fields if field not in later}
    fields |= {field: LazyArray(partial(of, name)) for field, name in later.items()}
    known = ContactPosterior(**fields)
    force = np.abs(of("true_contact_force"))
    found = of("contact_force"), of("contact_arc_length"), known, np.full(len(force), np.nan)
    transverse = of("true_transverse_force"), of("transverse_force"), of("transverse_force_std")
    return _stated(force, of("true_contact_arc_length"), *found, transverse).at(force > _LEAST_FORCE)
