"""Situations in which a user meets contacts, and what `contact` states of the contacts in them.

By statics: single contacts at rest with any friction, sliding ones, pairs, contacts spread along the finger, a plant of
more segments than the nominal finger, a plant that leaves the plane under an estimator that does not know it, and
contacts in space. Simulated: a finger that presses on a peg, at rest and shortly after steps of pressure, and an arm
that carries a box.

The nominal model is exact, and declared to be; or stiffness and pressure are wrong, by up to 10 and 2 %, which either
is declared or not: the uncertainty is the default one then.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.batches import Later
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.spatial_contact import SpatialContactShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.extras.studies.contacts.dataset import Contacts, read_finger
from soft_gripper.extras.studies.contacts.estimates import REALISTIC, Condition
from soft_gripper.extras.studies.contacts.space import SpatialContacts, contacts_in_space, finger_in_space
from soft_gripper.extras.studies.contacts.statics import rubbing_contacts, several_contacts
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

PLACES = 0.1, 1.0  # of the length
FRICTION, MOST_FRICTION = 0.9, 1.0  # of contacts at rest, at most, and of sliding ones
FINER = 48  # segments of a plant under a nominal finger of 12
STIFFNESS, PRESSURE = (-10, -5, 0, 5, 10), 0.02  # %, errors of the nominal one; share, the largest error
MODELS = "exact, declared", "wrong, defaults", "wrong, called exact"
_MOVED, _PERIOD = 100, 0.05  # samples of a motion into the contact and of holding it, s between them


class Case(NamedTuple):
    """Sensors and nominal model of an estimator."""

    sections: int
    realistic: bool
    model: str = MODELS[0]

    @property
    def exact(self) -> bool:
        """Whether the nominal finger is that which is simulated, and the pressure is measured exactly."""
        return self.model == MODELS[0]

    @property
    def errors(self) -> StrainErrors | None:
        return strain_errors(self.sensor) if self.realistic else None

    @property
    def sensor(self) -> SensorConfig:
        """With the sections of the plane."""
        return SensorConfig(sections=self.sections, errors=StrainErrorsConfig(preset=REALISTIC))

    @property
    def assumed(self) -> Uncertainty:
        found = uncertainty_of(self.errors)
        return found if self.model == MODELS[1] else replace(found, bend_per_pressure=EXACT)


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

    def at(self, rows: NDArray[np.bool_]) -> "Stated":
        """Some of them."""
        return Stated(*(values[rows] for values in self))


def joined(parts: list[Stated]) -> Stated:
    """All contacts of several."""
    return Stated(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def single(number: int, seed: int) -> Contacts:
    """Contacts at rest with any friction up to FRICTION."""
    return rubbing_contacts(number, FRICTION, np.random.default_rng(seed).uniform(size=number), seed, PLACES)


def sliding(number: int, seed: int) -> Contacts:
    """Contacts at the edge of a cone of up to MOST_FRICTION."""
    cone = np.random.default_rng(seed).uniform(0.2, MOST_FRICTION, number)
    return rubbing_contacts(number, cone, 1.0, seed, PLACES)


def finer(number: int, seed: int) -> Contacts:
    """Contacts on a finger of FINER segments."""
    share, finger = np.random.default_rng(seed).uniform(size=number), replace(read_finger(), segments=FINER)
    return rubbing_contacts(number, FRICTION, share, seed, PLACES, finger)


def _friction(number: int, seed: int) -> Array:
    return FRICTION * np.random.default_rng(seed).uniform(size=number)


PLANAR: dict[str, Callable[[int, int], Contacts]] = {
    "at rest": single,
    "sliding": sliding,
    "two contacts": lambda number, seed: several_contacts(number, FRICTION, seed),
    "a spread contact": lambda number, seed: several_contacts(number, FRICTION, seed, spread=True),
    "a plant of 48 segments": finer,
}
IN_SPACE = "a plant in space", "in space"
PEG, ARM = ("peg, at rest", "peg, after a step"), ("carried by an arm",)


def drawn(situation: str, case: Case, number: int, seed: int) -> Stated:
    """Statements about contacts by statics."""
    if situation in PLANAR:
        contacts = _contacts(situation, number, seed)
        finger = replace(read_finger(), segments=contacts.q.shape[-1])
        return _in_plane(case, contacts, SensorLayout(finger, case.sections), seed)
    if situation == "in space":
        return _in_space(case, contacts_in_space(number // 2, _friction(number // 2, seed), seed), seed)
    return _leaving_the_plane(case, contacts_in_space(number, _friction(number, seed), seed, faces=2), seed)


@cache
def _contacts(situation: str, number: int, seed: int) -> Contacts:
    """Contacts of a situation of PLANAR, the same for all cases."""
    return PLANAR[situation](number, seed)


def _read(layout: MeasurementModel, q: Array, case: Case, rng: np.random.Generator) -> Array:
    """Readings of postures, (M, D), into which the finger has moved."""
    if case.errors is None:
        return np.asarray(layout.response.reading(1 + layout.predict(q)))
    motion = np.clip(np.linspace(0, 2, _MOVED), 0, 1)[:, None, None] * q
    disturbed = disturb(case.errors, 1 + layout.predict(motion), _PERIOD, rng)[-1]
    return np.asarray(layout.response.reading(disturbed))


def _wrong(case: Case, number: int, rng: np.random.Generator) -> tuple[Array, list[tuple[Condition, NDArray[np.int_]]]]:
    """Measured over true pressure, and the contacts for each nominal stiffness."""
    if case.exact:
        return np.ones(number), [(Condition(), np.arange(number))]
    stiffness = rng.integers(len(STIFFNESS), size=number)
    conditions = [Condition(f"{percent:+d} %" if percent else None) for percent in STIFFNESS]
    parts = [(each, np.flatnonzero(stiffness == i)) for i, each in enumerate(conditions)]
    return 1 + PRESSURE * rng.uniform(-1, 1, number), [(each, at) for each, at in parts if len(at)]


def _in_plane(case: Case, contacts: Contacts, layout: SensorLayout, seed: int) -> Stated:
    rng, count = np.random.default_rng(seed), len(contacts.force)
    readings = _read(layout, contacts.q, case, rng)
    measured, parts = _wrong(case, count, rng)
    found = []
    for condition, at in parts:
        nominal = SensorLayout(condition.nominal_finger(read_finger()), case.sections)
        estimator = ContactShape(nominal, case.assumed)
        driving = nominal.finger.pressure_torque(measured[at] * contacts.pressure[at])
        given = readings[at], driving, contacts.gravity[at]
        contact = estimator(*given).contact
        assert contact is not None
        truth = np.abs(contacts.force[at]), contacts.arc_length[at], np.full(len(at), np.nan)
        found.append(_stated(*truth, np.abs(contact.force), contact.arc_length, estimator.posterior(*given)))
    return joined(found)


def _leaving_the_plane(case: Case, contacts: SpatialContacts, seed: int) -> Stated:
    """By sensors and an estimator that know of bending alone."""
    q, (x, _, z) = contacts.q[:, : read_finger().segments], contacts.gravity.T
    rest = np.zeros_like(contacts.pressure)
    force, total = contacts.normal_force, np.linalg.norm(contacts.force, axis=-1)
    side = np.full(len(rest), "inner")
    planar = Contacts(q, contacts.pressure, z + 1j * x, force, total, contacts.arc_length, q, side, rest, rest)
    return _in_plane(case, planar, SensorLayout(read_finger(), case.sections), seed)


def _in_space(case: Case, contacts: SpatialContacts, seed: int) -> Stated:
    rng, finger = np.random.default_rng(seed), finger_in_space()
    config = SensorConfig(layout="four_faces_and_diagonal", sections=case.sections)
    readings = _read(sensor_layout(finger, config), contacts.q, case, rng)
    measured, parts = _wrong(case, len(contacts.q), rng)
    found = []
    for condition, at in parts:
        nominal = condition.nominal_finger(finger)
        estimator = SpatialContactShape(sensor_layout(nominal, config), case.assumed)
        driving = np.zeros((len(at), contacts.q.shape[-1]))
        driving[:, : finger.segments] = nominal.pressure_torque(measured[at] * contacts.pressure[at])
        given = readings[at], driving, contacts.gravity[at]
        contact = estimator(*given).contact
        assert contact is not None
        true, size = contacts.force[at], np.linalg.norm(contact.force, axis=-1)
        cosine = (true * contact.force).sum(axis=-1) / (np.linalg.norm(true, axis=-1) * size + 1e-30)
        degrees = np.where(size > 0, np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.nan)
        along = np.linalg.norm(true, axis=-1) / contacts.normal_force[at]  # the estimate has the friction as well
        truth = contacts.normal_force[at], contacts.arc_length[at], degrees
        posterior = estimator.posterior(*given).known
        found.append(_stated(*truth, size / along, contact.across.arc_length, posterior))
    return joined(found)


def _stated(
    force: Array, place: Array, degrees: Array, estimated: Array, estimated_place: Array, known: ContactPosterior
) -> Stated:
    """From places in m."""
    length = read_finger().length
    return Stated(
        *(force, place / length, estimated, estimated_place / length, degrees),
        *(known.probability, known.force_interval, known.force_bounds, known.arc_length_set / length),
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
        recording = simulate(
            load_scenario(
                "obstructed_inside",
                [
                    *_changes(case, rng),
                    *(f"pressure.settle={HELD - 0.1}", "pressure.hold_samples=10"),
                    *(
                        f"pressure.steps={{all: [0.0], left_finger: {steps}}}",
                        f"models.1.X_PC.translation=[{x}, 0, {z}]",
                    ),
                ],
            )
        )
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
        mass = f"models.3.mesh.mass={rng.uniform(0.03, 0.06)}"
        recording = simulate(load_scenario("pick_and_place_box", [*_changes(case, rng), mass]))
        for finger in ("left_finger", "right_finger"):
            place = np.asarray(recording[f"{finger}.X_WB"])[:, :, 3]
            rate = np.gradient(np.gradient(place, 0.01, axis=0), 0.01, axis=0)
            moving = np.flatnonzero(np.linalg.norm(rate, axis=-1) > _ACCELERATED)
            found.append(_recorded(recording, finger, moving[:: max(len(moving) // 100, 1)]))
    return {ARM[0]: joined(found)}


def _changes(case: Case, rng: np.random.Generator) -> list[str]:
    changes = ["estimator.type=contact", f"sensor.sections={case.sections}", f"sensor.seed={rng.integers(2**31)}"]
    if case.realistic:
        changes.append(f"sensor.errors.preset={REALISTIC}")
    if case.model != MODELS[1]:
        changes.append(f"estimator.uncertainty={_text(case.assumed)}")
    if case.exact:
        return changes
    stiffness, leak = rng.choice(STIFFNESS), PRESSURE * rng.uniform()
    wrong = [f"pressure.leaks={{all: {leak}}}", *([f"nominal.youngs_modulus={stiffness:+d} %"] if stiffness else [])]
    return [*changes, *wrong]


def _text(assumed: Uncertainty) -> str:
    return "{" + ", ".join(f"{name}: {value}" for name, value in vars(assumed).items()) + "}"


def _recorded(recording: Recording, finger: str, rows: NDArray[np.int_]) -> Stated:
    def of(name: str) -> Array:
        values = np.asarray(recording[f"{finger}.{name}"])[rows]
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    fields = (field for field in ContactPosterior._fields if field != "interval")
    interval = Later(lambda: of("contact_force_interval"))
    known = ContactPosterior(interval=interval, **{field: of(f"contact_{field}") for field in fields})
    force = np.abs(of("true_contact_force"))
    truth = force, of("true_contact_arc_length"), np.full(len(force), np.nan)
    stated = _stated(*truth, np.abs(of("contact_force")), of("contact_arc_length"), known)
    return stated.at(force > _LEAST_FORCE)
