"""Parameters of a finger and its set-up that can be fitted: their keys, as a vector (P,), and the model of a vector.

Another parameter is a line of `KEYS`. Positive values are fitted as logarithms. A pressure law has two fitted numbers,
its gain and its margin,

    effective = gain p / (1 - (1 - margin) p / p_max) ,

p_max being the highest pressure of the recordings. The bend due to a silicone chamber grows faster than the pressure,
and beyond all bounds where it balloons; the margin is the distance of p_max from there. Above 1, the bend grows more
slowly than the pressure. The law rises between 0 and p_max for all values. At one pressure the gain
alone is fitted. It is written to the file as points.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.least_squares import Fit
from soft_gripper.fingers.cross_section import SIZES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import PressureLaw

PRESSURE_LAW = "pressure_law"
HELD_POSE = "held_pose"  # is fitted to every recording
MARGINS = (0.01, 10.0)  # of a pressure law


@dataclass(frozen=True)
class Model:
    """A finger in its set-up."""

    finger: Finger
    setup: Setup = field(default_factory=Setup)


Room = tuple[float, float]


@dataclass(frozen=True)
class Key:
    """A parameter that can be fitted: reads its values from a model, and sets them."""

    unit: str
    get: Callable[[Model], Sequence[float]]
    put: Callable[[Model, Sequence[float]], Model]
    positive: bool = True
    scale: float = 0.1  # typical change: of the logarithm, or of the value if it may be negative
    room: Room | Callable[[Model], Room] = (-np.inf, np.inf)  # bounds of sensible values, and of the search


def _section_key(name: str, unit: str) -> Key:
    """Key of a field of all cross-sections: the first nonzero value is fitted, the others keep their ratios to it."""

    def get(model: Model) -> Sequence[float]:
        values = [getattr(section, name) for section in model.finger.cross_sections]
        return (next(filter(None, values), 0.0),)

    def put(model: Model, values: Sequence[float]) -> Model:
        ratio = values[0] / get(model)[0]
        changed_finger = model.finger.with_sections(lambda part: replace(part, **{name: getattr(part, name) * ratio}))
        return replace(model, finger=changed_finger)

    return Key(unit, get, put)


def _modulus_ratio(model: Model) -> Sequence[float]:
    """Young's modulus at the tip over that at the base."""
    return [float(model.finger.tip.youngs_modulus / model.finger.base.youngs_modulus)]


def _set_modulus_ratio(model: Model, values: Sequence[float]) -> Model:
    """Multiplies the modulus by a factor that is linear along the finger, and 1 at the base."""
    change, places = values[0] / _modulus_ratio(model)[0] - 1, iter(model.finger.places)
    return replace(
        model,
        finger=model.finger.with_sections(
            lambda part: replace(part, youngs_modulus=part.youngs_modulus * (1 + change * next(places)))
        ),
    )


_Parts = tuple[Callable[[Model], Sequence[Any]], Callable[[Model, list[Any]], Model]]  # gets and puts them
_FINGER_PARTS: _Parts = (lambda model: [model.finger], lambda model, parts: replace(model, finger=parts[0]))
_SETUP_PARTS: _Parts = (lambda model: [model.setup], lambda model, parts: replace(model, setup=parts[0]))
_CREEP_PARTS: _Parts = (
    lambda model: model.finger.creep,
    lambda model, parts: replace(model, finger=replace(model.finger, creep=tuple(parts))),
)
_TENDON_PARTS: _Parts = (
    lambda model: model.finger.tendons,
    lambda model, parts: replace(model, finger=replace(model.finger, tendons=tuple(parts))),
)


def _field_key(parts: _Parts, name: str, unit: str, **fit: Any) -> Key:
    """Key of a field of every part."""
    get_parts, put_parts = parts

    def put(model: Model, values: Sequence[float]) -> Model:
        cleared = values if parts in (_FINGER_PARTS, _CREEP_PARTS) else _clear_small(np.array(values))
        pairs = zip(get_parts(model), cleared, strict=True)
        return put_parts(model, [replace(part, **{name: value}) for part, value in pairs])

    return Key(unit, lambda model: [getattr(part, name) for part in get_parts(model)], put, **fit)


def _setup_key(name: str, unit: str, positive: bool, scale: float, room: Room = (-np.inf, np.inf)) -> Key:
    return _field_key(_SETUP_PARTS, name, unit, positive=positive, scale=scale, room=room)


def _angles(model: Model) -> Sequence[float]:
    return [float(np.arctan2(tendon.y[0], tendon.x[0])) for tendon in model.finger.tendons]


def _turn_tendons(model: Model, values: Sequence[float]) -> Model:
    """Rotates the path of each tendon about the middle of the section, to begin at an angle, rad."""
    tendons = []
    for tendon, angle, last_angle in zip(model.finger.tendons, values, _angles(model), strict=True):
        columns = np.atleast_2d(np.broadcast_arrays(tendon.x, tendon.y))
        path = np.exp(1j * (angle - last_angle)) * (columns[0] + 1j * columns[1])
        tendons.append(replace(tendon, x=_clear_small(path.real), y=_clear_small(path.imag)))
    return replace(model, finger=replace(model.finger, tendons=tuple(tendons)))


def _tendon_lever(model: Model) -> Sequence[float]:
    """Distance of the first tendon from the middle of the section, at its beginning."""
    return [float(np.hypot(tendon.x[0], tendon.y[0])) for tendon in model.finger.tendons[:1]]


def _set_lever(model: Model, values: Sequence[float]) -> Model:
    """Moves all tendons in proportion, until the first has a distance from the middle of the section."""
    ratio = values[0] / _tendon_lever(model)[0]
    tendons = (
        replace(tendon, x=tuple(ratio * x for x in tendon.x), y=tuple(ratio * y for y in tendon.y))
        for tendon in model.finger.tendons
    )
    return replace(model, finger=replace(model.finger, tendons=tuple(tendons)))


def _lever_room(model: Model) -> Room:
    """Range of the first tendon's distance from the middle in which no tendon leaves the section at any angle."""
    finger, max_ratio = model.finger, np.inf
    for tendon in finger.tendons:
        s = finger.length * np.array(tendon.at)
        section = finger.section(s)
        half_sizes = np.minimum(section.thickness, section.width) / 2
        offsets = np.hypot(tendon.value_at("x", s, finger.length), tendon.value_at("y", s, finger.length))
        max_ratio = min(max_ratio, float((half_sizes / np.maximum(offsets, SIZES[0])).min()))
    return 0.0, max(max_ratio, 1.0) * _tendon_lever(model)[0]


def _clear_small(values: Array) -> tuple[float, ...]:
    """Replaces values that are too small for a finger or its set-up by 0."""
    return tuple(np.where(np.abs(values) < SIZES[0], 0.0, values).tolist())


def pressure_law(highest: float, gain: float, margin: float) -> PressureLaw:
    """Law of a gain times the pressure; the highest pressure, Pa, leaves a margin of the stiffness.

    The lost share of the stiffness grows with the pressure; a vacuum takes none.
    """
    return PressureLaw((-highest, 0.0, highest), (-gain * highest, 0.0, gain * highest), (0.0, 0.0, 1 - margin))


def pressure_law_keys(pressures: Sequence[float]) -> dict[str, Key]:
    """Keys of a pressure law that is fitted to recordings at these pressures, Pa: gain and margin."""
    highest_pressure = max(pressures)

    def numbers(model: Model) -> tuple[float, float]:
        law = model.finger.pressure_law or PressureLaw((0.0, highest_pressure), (0.0, highest_pressure))
        return float(law.softening(highest_pressure)), 1 - float(law.share_taken(highest_pressure))

    def change_law(model: Model, gain: float, margin: float) -> Model:
        law = pressure_law(highest_pressure, gain, margin)
        return replace(model, finger=replace(model.finger, pressure_law=law))

    def with_gain(model: Model, values: Sequence[float]) -> Model:
        return change_law(model, values[0], numbers(model)[1])

    def with_margin(model: Model, values: Sequence[float]) -> Model:
        return change_law(model, numbers(model)[0], values[0])

    gain = {f"{PRESSURE_LAW}.gain": Key("1", lambda model: numbers(model)[:1], with_gain)}
    margin = {f"{PRESSURE_LAW}.margin": Key("1", lambda model: numbers(model)[1:], with_margin, room=MARGINS)}
    return gain | margin if len(set(pressures)) > 1 else gain


KEYS = {
    "youngs_modulus": _section_key("youngs_modulus", "Pa"),
    "youngs_modulus_ratio": Key("1", _modulus_ratio, _set_modulus_ratio),
    "density": _section_key("density", "kg/m^3"),
    "chamber_width": _section_key("chamber_width", "m"),
    "chamber_thickness": _section_key("chamber_thickness", "m"),
    "layer_shear_modulus": _section_key("layer_shear_modulus", "Pa"),
    "relaxation_time": _field_key(_FINGER_PARTS, "relaxation_time", "s"),
    "length": _field_key(_FINGER_PARTS, "length", "m"),
    "shear_factor": _field_key(_FINGER_PARTS, "shear_factor", "1"),
    "creep.share": _field_key(_CREEP_PARTS, "share", "1", room=(1e-3, 0.6)),
    "creep.time": _field_key(_CREEP_PARTS, "time", "s", room=(5e-3, 100.0)),
    "mounting_x": _setup_key("mounting_x", "m", False, 1e-3),
    "mounting_z": _setup_key("mounting_z", "m", False, 1e-3),
    "mounting_angle": _setup_key("mounting_angle", "rad", False, 0.01),
    "load_x": _setup_key("load_x", "m", False, 1e-3),
    "load_z": _setup_key("load_z", "m", False, 1e-3),
    "load_friction": _setup_key("load_friction", "m", False, 1e-4, (0.0, 0.01)),
    "marker_mass": _setup_key("marker_mass", "kg", False, 1e-3, (0.0, 0.1)),
    "fill_time": _setup_key("fill_time", "s", True, 0.1, (5e-3, 1.0)),
    "swelling": _setup_key("swelling", "1", True, 0.1, (0.1, 20.0)),
    "supply_lag": _setup_key("supply_lag", "Pa", False, 300.0, (0.0, 1e5)),
    "supply_time": _setup_key("supply_time", "s", True, 0.1, (0.05, 20.0)),
    "dry_friction": _setup_key("dry_friction", "rad", False, 0.03, (0.0, 1.0)),
    "backlash": _setup_key("backlash", "m", False, 3e-4, (0.0, 0.05)),
    "delay": _setup_key("delay", "s", False, 0.05, (-2.0, 2.0)),
    "tendon.angle": Key("rad", _angles, _turn_tendons, positive=False),
    "tendon.lever": Key("m", _tendon_lever, _set_lever, room=_lever_room),
    "tendon.slack": _field_key(_TENDON_PARTS, "slack", "m", positive=False, scale=3e-4),
    "tendon.stiffness": _field_key(_TENDON_PARTS, "stiffness", "N/m", scale=0.3),
}


@dataclass(frozen=True)
class FreeParameters:
    """Chosen keys of a model as one vector of numbers to fit."""

    model: Model
    keys: dict[str, Key]
    fixed: frozenset[str] = frozenset()  # names of numbers that stay as the model has them

    @property
    def _all_names(self) -> list[str]:
        key_counts = [(name, len(key.get(self.model))) for name, key in self.keys.items()]
        return [name if size == 1 else f"{name}.{i + 1}" for name, size in key_counts for i in range(size)]

    @property
    def _is_free(self) -> NDArray[np.bool_]:
        return np.array([name not in self.fixed for name in self._all_names], dtype=bool)

    def _key_values(self, get_value: Callable[[Key], Any]) -> list[Any]:
        """Value of every free number's key."""
        values = [get_value(key) for key in self.keys.values() for _ in key.get(self.model)]
        return [value for value, is_free in zip(values, self._is_free, strict=True) if is_free]

    @property
    def names(self) -> list[str]:
        """Names of all numbers; those of a key with several numbers are numbered from 1."""
        return [name for name in self._all_names if name not in self.fixed]

    @property
    def units(self) -> list[str]:
        """Units of all numbers."""
        return self._key_values(attrgetter("unit"))

    @property
    def scales(self) -> Array:
        """Typical changes of the vector."""
        return np.array(self._key_values(attrgetter("scale")))

    @property
    def is_positive(self) -> NDArray[np.bool_]:
        """Whether each number is fitted as a logarithm."""
        return np.array(self._key_values(attrgetter("positive")), dtype=bool)

    @property
    def start(self) -> Array:
        """Vector of the current model."""
        values = np.array([value for key in self.keys.values() for value in key.get(self.model)])[self._is_free]
        return np.where(self.is_positive, np.log(np.where(self.is_positive, values, 1.0)), values)

    def starts(self, count: int, seed: int, jitter: float) -> Array:
        """Vectors from which a fit may begin, (count, P): that of the current model, and random ones about it.

        `jitter` is the standard deviation of the random ones, in typical changes.
        """
        changes = np.random.default_rng(seed).normal(size=(count, len(self.start))) * jitter * self.scales
        changes[0] = 0.0
        return self.start + changes

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the vector."""
        rooms = self._key_values(lambda key: key.room(self.model) if callable(key.room) else key.room)
        room = np.array(rooms).reshape(-1, 2).T
        with np.errstate(divide="ignore", invalid="ignore"):
            lower_bounds, upper_bounds = np.where(self.is_positive, np.log(np.maximum(room, 0.0)), room)
        return lower_bounds, upper_bounds

    def steps(self, x: Array, fraction: float) -> Array:
        """Steps for finite differences, a fraction of the typical changes; backward if the model is impossible."""
        steps, (_, upper) = fraction * self.scales, self.bounds
        for i, point in enumerate(x + np.diag(steps)):
            if point[i] > upper[i] or not self._is_possible(point):
                steps[i] *= -1
        return steps

    def _is_possible(self, x: Array) -> bool:
        try:
            self.build_model(x)
        except InputError:
            return False
        return True

    def values(self, x: Array) -> Array:
        """Numbers of a vector, in their units."""
        return np.where(self.is_positive, np.exp(np.where(self.is_positive, x, 0.0)), x)

    def build_model(self, x: Array) -> Model:
        """Model with the values of a vector.

        Raises:
            InputError: if such a finger is impossible.
        """
        numbers = np.array([value for key in self.keys.values() for value in key.get(self.model)], dtype=float)
        numbers[self._is_free] = self.values(x)
        model, remaining_values = self.model, numbers.tolist()
        for key in self.keys.values():
            count = len(key.get(self.model))
            model, remaining_values = key.put(model, remaining_values[:count]), remaining_values[count:]
        return model

    def fix(self, x: Array, names: Iterable[str]) -> "FreeParameters":
        """Copy at a vector, with the named numbers fixed."""
        return replace(self, model=self.build_model(x), fixed=self.fixed | frozenset(names))


R = TypeVar("R")  # type of the recordings


@dataclass(frozen=True)
class FingerFit(Fit[Model], Generic[R]):
    """Free parameters fitted to recordings; events and placements of these follow them."""

    free: FreeParameters
    recordings: tuple[R, ...]  # with fitted values of unrecorded quantities


def free_parameters(
    finger: Finger, names: Sequence[str], pressures: Sequence[float], setup: Setup | None = None
) -> FreeParameters:
    """Collects the parameters of a finger that a fit may vary.

    Args:
        finger: initial guess of the fit.
        names: names of the keys.
        pressures: pressures of the recordings, Pa; may be empty.
        setup: initial guess of the set-up; None: the default.
    """
    law = pressure_law_keys(pressures) if pressures else {}
    model, keys = Model(finger, replace(setup or Setup(), held_pose=HELD_POSE in names)), dict[str, Key]()
    for name in names:
        if list(names).count(name) > 1:
            raise InputError("identify", "--free", name, "appears more than once")
        if name == HELD_POSE:
            continue
        named_keys = law if name == PRESSURE_LAW else {name: KEYS[name]} if name in KEYS else {}
        if not named_keys:
            reason = "the recordings have no pressure to fit it to" if name == PRESSURE_LAW else "there is no such key"
            key_names = ", ".join([*KEYS, HELD_POSE, *([PRESSURE_LAW] if law else [])])
            raise InputError("identify", "--free", name, f"{reason}; known: {key_names}")
        for key in named_keys.values():
            values = key.get(model)
            if not len(values) or (key.positive and not min(values) > 0):
                expected = "the finger file has no initial guess for it; add one there"
                raise InputError("identify", "--free", name, expected)
        keys |= named_keys
    if not keys:
        raise InputError("identify", "--free", " ".join(names), "name a key of the finger or its set-up as well")
    return FreeParameters(model, keys)
