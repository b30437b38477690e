"""Situations in which a user meets contacts, and estimates of `contact` in them.

In: a situation and the setup of an estimator. Out: `Estimates`. A new situation by statics is an entry of STATICS or
DIFFERENCES.

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
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import softened
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import Estimates, disturbed_readings, estimate_contacts, joined
from studies.contacts.self_calibration import Scale
from studies.contacts.statics import (
    FRICTION,
    contacts_in_space,
    finger_in_space,
    rubbing_contacts,
    several_contacts,
)
from studies.estimator_setup import MODELS, REALISTIC, EstimatorSetup
from studies.robustness.plants import RUBBER

MAX_FRICTION = 1.0  # of sliding contacts
FINER = 48  # segments of a plant under a nominal finger of 12
STRONG, NEAR = {"inner": (2.0, 5.0), "outer": (2.0, 5.0)}, (0.1, 1 / 3)  # N; fractions of the length
ROUGH = 1.3  # friction, above the 0.9 of the default uncertainty
BORDER_SHIFT = 1 / 12  # of the length, 10 mm
STIFFNESS = (-10, -5, 0, 5, 10)  # %, errors of the nominal stiffness
PRESSURE = 0.02  # fraction, largest error of the pressure
_MOTION_SAMPLES, _PERIOD = 100, 0.05  # samples of a motion into the contact and of holding it, s between them


class Statics(NamedTuple):
    """Contacts by statics of a finger, its nominal finger and sensors, which by default see bending alone."""

    contacts: Callable[..., Contacts]  # of a number and a seed, and of ranges of `forces` in DIFFERENCES
    nominal: Callable[[], Finger] = read_finger
    layout: str = "sides"
    border_shift: float = 0.0  # fraction of the length by which the middle border lies beyond the nominal one


def _sliding_contacts(number: int, seed: int) -> Contacts:
    """Contacts at the edge of a cone of up to MAX_FRICTION."""
    cone = np.random.default_rng(seed).uniform(0.2, MAX_FRICTION, number)
    return rubbing_contacts(number, seed, cone, 1.0)


def _space_contacts(number: int, seed: int, faces: int) -> Contacts:
    friction = FRICTION * np.random.default_rng(seed).uniform(size=number)
    return contacts_in_space(number, friction, seed, faces=faces)


def graded_finger(change: float) -> Finger:
    """The shipped finger, stiffer by this fraction at the base, softer by it at the tip, and linear between."""
    finger = read_finger()
    base, tip = (softened(finger, 1 / (1 + fraction)) for fraction in (change, -change))
    return replace(finger, base=base.base, tip=tip.tip)


STATICS = {
    "at rest": Statics(rubbing_contacts),
    "sliding": Statics(_sliding_contacts),
    "two contacts": Statics(lambda number, seed: several_contacts(number, FRICTION, seed)),
    "a spread contact": Statics(lambda number, seed: several_contacts(number, FRICTION, seed, is_spread=True)),
    "a plant of 48 segments": Statics(partial(rubbing_contacts, finger=lambda: replace(read_finger(), segments=FINER))),
    "a plant in space": Statics(lambda number, seed: _space_contacts(number, seed, faces=2)),
    "in space": Statics(
        lambda number, seed: _space_contacts(number // 2, seed, faces=4), finger_in_space, "four_faces_and_diagonal"
    ),
}
DIFFERENCES = {
    "none": Statics(rubbing_contacts),
    "stiffness +5 % at the base, -5 % at the tip": Statics(
        partial(rubbing_contacts, finger=partial(graded_finger, 0.05))
    ),
    "stiffness -10 % at the base, +10 % at the tip": Statics(
        partial(rubbing_contacts, finger=partial(graded_finger, -0.10))
    ),
    "a border between sections 10 mm off": Statics(rubbing_contacts, border_shift=BORDER_SHIFT),
    "forces of 2 to 5 N before a third of the length": Statics(partial(rubbing_contacts, places=NEAR, forces=STRONG)),
    "sliding with friction of 1.3": Statics(partial(rubbing_contacts, friction=ROUGH, fraction=1.0)),
    "a neo-Hookean plant": Statics(partial(rubbing_contacts, finger=lambda: RUBBER.finger(read_finger()))),
}
PEG, ARM = ("peg, at rest", "peg, after a step"), ("carried by an arm",)
_contacts = cache(lambda make, number, seed: make(number, seed))  # the same for all setups


def static_estimates(situation: Statics, setup: EstimatorSetup, number: int, seed: int) -> Estimates:
    """Estimates about `number` contacts by statics, with independent sensor errors."""
    contacts, rng = _contacts(situation.contacts, number, seed), np.random.default_rng(seed)
    finger, sensors = situation.nominal(), setup
    if situation.border_shift:
        borders = np.arange(1, setup.sections) / setup.sections
        borders[len(borders) // 2] += situation.border_shift
        sensors = replace(setup, borders=tuple(borders.tolist()))
    simulated = sensors.layout(replace(finger, segments=contacts.finger.segments), situation.layout)
    readings = read_pressed(simulated, contacts.q, setup.errors, rng)
    pressure, stiffnesses = _model_errors(setup, len(contacts.q), rng)
    parts = []
    for stiffness in np.unique(stiffnesses):
        rows, nominal = stiffnesses == stiffness, replace(setup, stiffness=stiffness / 100)
        layout = nominal.layout(nominal.nominal_finger(finger), situation.layout)
        scale = Scale(pressure[rows])
        parts.append(estimate_contacts(layout, setup.uncertainty, readings[rows], contacts.subset(rows), scale))
    return joined(parts)


def read_pressed(layout: MeasurementModel, q: Array, errors: StrainErrors | None, rng: np.random.Generator) -> Array:
    """Readings of postures, (M, D) -> (M, R), in which the sensors see the first deformations alone."""
    q = q[:, : len(layout.straight)]
    if errors is None:
        return layout.read(q)
    motion = np.clip(np.linspace(0, 2, _MOTION_SAMPLES), 0, 1)[:, None, None] * q
    return np.asarray(disturbed_readings(layout, 1 + layout.predict(motion), errors, _PERIOD, rng)[-1])


def _model_errors(setup: EstimatorSetup, number: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Measured over true pressure, and errors of the nominal stiffness, %, of contacts, each (M,)."""
    if setup.is_exact:
        return np.ones(number), np.zeros(number)
    stiffnesses = np.array(STIFFNESS)[rng.integers(len(STIFFNESS), size=number)]
    return 1 + PRESSURE * rng.uniform(-1, 1, number), stiffnesses


HELD = 0.5  # s, of every step of pressure
_STEPS, _DELAYS = 7, (0.05, 0.1, 0.15, 0.2, 0.25)  # s after a step
_MIN_FORCE, _MIN_ACCELERATION = 0.05, 0.5  # N, m/s^2
_NEAREST, _GAP = 0.15, 6e-3  # fraction of the length; m, between finger and peg at the tip, at most


def peg_estimates(setup: EstimatorSetup, number: int, seed: int) -> dict[str, Estimates]:
    """Estimates of a finger that presses on a peg, in `number` runs, by situation."""
    parts: dict[str, list[Estimates]] = {situation: [] for situation in PEG}
    for i in range(number):
        rng = np.random.default_rng([seed, i])
        fraction = rng.uniform(_NEAREST, 0.97)
        x, z = -0.0245 + _GAP * fraction * rng.uniform(), 0.2 - fraction * read_finger().length
        steps = np.round(rng.uniform(20e3, 150e3, _STEPS), 1).tolist()
        changes = _changes(setup, rng) | {
            "pressure.settle": HELD - 0.1,
            "pressure.hold_samples": 10,
            "pressure.steps": {"all": [0.0], "left_finger": steps},
            "models.1.X_PC.translation": [x, 0, z],
        }
        recording = simulate(changed_scenario("obstructed_inside", changes))
        begins = HELD * np.arange(_STEPS)[:, None]
        for situation, delays in zip(PEG, ([HELD - 0.01], _DELAYS), strict=True):
            rows = np.round((begins + delays).ravel() / 0.01).astype(int)
            parts[situation].append(_recorded_estimates(recording, "left_finger", rows))
    return {situation: joined(estimates) for situation, estimates in parts.items()}


def arm_estimates(setup: EstimatorSetup, number: int, seed: int) -> dict[str, Estimates]:
    """Estimates of two fingers that hold a box while their arm accelerates, in `number` runs."""
    parts = []
    for i in range(number):
        rng = np.random.default_rng([seed, i])
        mass = {"models.3.mass": rng.uniform(0.03, 0.06)}
        recording = simulate(changed_scenario("pick_and_place_box", _changes(setup, rng) | mass))
        for finger in ("left_finger", "right_finger"):
            position = np.asarray(recording[f"{finger}.X_WB"])[:, :, 3]
            acceleration = np.gradient(np.gradient(position, 0.01, axis=0), 0.01, axis=0)
            moving_samples = np.flatnonzero(np.linalg.norm(acceleration, axis=-1) > _MIN_ACCELERATION)
            parts.append(_recorded_estimates(recording, finger, moving_samples[:: max(len(moving_samples) // 100, 1)]))
    return {ARM[0]: joined(parts)}


def _changes(setup: EstimatorSetup, rng: np.random.Generator) -> dict[str, Any]:
    """Changes of a scenario by dotted keys."""
    changes = {"estimator.type": "contact", "sensor.sections": setup.sections, "sensor.seed": rng.integers(2**31)}
    if setup.noise:
        changes["sensor.errors.preset"] = REALISTIC
    if setup.model != MODELS[1]:
        changes["estimator.uncertainty"] = vars(setup.uncertainty)
    if not setup.is_exact:
        stiffness, changes["pressure.leaks"] = rng.choice(STIFFNESS), {"all": PRESSURE * rng.uniform()}
        if stiffness:
            changes["nominal.finger.youngs_modulus"] = f"{stiffness:+d} %"
    return changes


def _recorded_estimates(recording: Recording, finger: str, rows: NDArray[np.int_]) -> Estimates:
    def signal(name: str) -> Array:
        values = np.asarray(recording[f"{finger}.{name}"])[rows]
        return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values

    length, no_values = read_finger().length, np.full(len(rows), np.nan)
    estimates = Estimates(
        force=np.abs(signal("true_contact_force")),
        location=signal("true_contact_arc_length") / length,
        transverse=signal("true_transverse_force"),
        estimated_force=signal("contact_force"),
        force_std=no_values,
        estimated_location=signal("contact_arc_length") / length,
        location_std=no_values,
        estimated_transverse=signal("transverse_force"),
        transverse_std=signal("transverse_force_std"),
        degrees=no_values,
        probability=signal("contact_probability"),
        interval=signal("contact_force_interval"),
        bounds=signal("contact_force_bounds"),
        location_set=signal("contact_arc_length_set") / length,
        transverse_interval=signal("transverse_force_interval"),
    )
    return estimates.subset(estimates.force > _MIN_FORCE)
