"""The parameters of a finger and its set-up that can be fitted: keys, and the effect of their values.

Values that are positive are fitted as logarithms. Of a pressure law, two numbers are fitted, its gain and its margin,

    effective = gain p / (1 - (1 - margin) p / p_max) ,

p_max being the highest pressure of the recordings. The bend due to a silicone chamber grows faster than the pressure,
and beyond all bounds where it balloons; the margin says how far below that p_max is. Above 1, the bend grows more
slowly than the pressure. Whatever the two numbers are, the law rises between 0 and p_max. At one pressure the gain
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
from soft_gripper.files.document import require
from soft_gripper.fingers.cross_section import SIZES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw
from soft_gripper.fingers.paths import Tendon

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


def _of_sections(name: str, unit: str) -> Key:
    """A field of every cross-section: the first that is not 0 is fitted, and the others keep their ratios to it."""

    def get(model: Model) -> Sequence[float]:
        values = [getattr(section, name) for section in model.finger.cross_sections]
        return (next(filter(None, values), 0.0),)

    def put(model: Model, values: Sequence[float]) -> Model:
        ratio = values[0] / get(model)[0]
        changed = model.finger.with_sections(lambda part: replace(part, **{name: getattr(part, name) * ratio}))
        return replace(model, finger=changed)

    return Key(unit, get, put)


def _of_finger(name: str, unit: str) -> Key:
    def put(model: Model, values: Sequence[float]) -> Model:
        changed: dict[str, Any] = {name: values[0]}
        return replace(model, finger=replace(model.finger, **changed))

    return Key(unit, lambda model: (getattr(model.finger, name),), put)


def _of_setup(name: str, unit: str, positive: bool, scale: float, room: Room = (-np.inf, np.inf)) -> Key:
    def put(model: Model, values: Sequence[float]) -> Model:
        changed: dict[str, Any] = {name: _sizeable(np.array(values[:1]))[0]}
        return replace(model, setup=replace(model.setup, **changed))

    return Key(unit, lambda model: (getattr(model.setup, name),), put, positive, scale, room)


def _of_creep(name: str, unit: str, room: Room) -> Key:
    """A field of each creep branch in the file."""

    def put(model: Model, values: Sequence[float]) -> Model:
        branches = zip(model.finger.creep, values, strict=True)
        creep: tuple[CreepBranch, ...] = tuple(replace(branch, **{name: value}) for branch, value in branches)
        return replace(model, finger=replace(model.finger, creep=creep))

    return Key(unit, lambda model: [getattr(branch, name) for branch in model.finger.creep], put, room=room)


def _of_tendons(unit: str, get: Callable[[Tendon], float], put: Callable[[Tendon, float], Tendon], **fit: Any) -> Key:
    """A number of each tendon."""

    def changed(model: Model, values: Sequence[float]) -> Model:
        tendons = tuple(put(tendon, value) for tendon, value in zip(model.finger.tendons, values, strict=True))
        return replace(model, finger=replace(model.finger, tendons=tendons))

    return Key(unit, lambda model: [get(tendon) for tendon in model.finger.tendons], changed, **fit)


def _tendon_field(name: str, unit: str, **fit: Any) -> Key:
    def put(tendon: Tendon, value: float) -> Tendon:
        return replace(tendon, **{name: _sizeable(np.array([value]))[0]})  # type: ignore[arg-type]

    return _of_tendons(unit, attrgetter(name), put, **fit)


def _angle(tendon: Tendon) -> float:
    return float(np.arctan2(tendon.y[0], tendon.x[0]))


def _turned(tendon: Tendon, angle: float) -> Tendon:
    """A tendon, its whole path turned about the middle of the section until it begins at an angle."""
    columns = np.atleast_2d(np.broadcast_arrays(tendon.x, tendon.y))
    turned = np.exp(1j * (angle - _angle(tendon))) * (columns[0] + 1j * columns[1])
    return replace(tendon, x=_sizeable(turned.real), y=_sizeable(turned.imag))


def _lever(model: Model) -> Sequence[float]:
    """Distance of the first tendon from the middle of the section, at its beginning."""
    return [float(np.hypot(tendon.x[0], tendon.y[0])) for tendon in model.finger.tendons[:1]]


def _at_lever(model: Model, values: Sequence[float]) -> Model:
    """All tendons moved away from the middle of the section, in proportion."""
    ratio = values[0] / _lever(model)[0]
    tendons = (
        replace(tendon, x=tuple(ratio * x for x in tendon.x), y=tuple(ratio * y for y in tendon.y))
        for tendon in model.finger.tendons
    )
    return replace(model, finger=replace(model.finger, tendons=tuple(tendons)))


def _lever_room(model: Model) -> Room:
    """How far the first tendon may be from the middle until one of them leaves the section, wherever it is turned."""
    finger, most = model.finger, np.inf
    for tendon in finger.tendons:
        s = finger.length * np.array(tendon.at)
        section = finger.section(s)
        half = np.minimum(section.thickness, section.width) / 2
        off = np.hypot(tendon.value_at("x", s, finger.length), tendon.value_at("y", s, finger.length))
        most = min(most, float((half / np.maximum(off, SIZES[0])).min()))
    return 0.0, max(most, 1.0) * _lever(model)[0]


def _sizeable(values: Array) -> tuple[float, ...]:
    """Values of a finger or its set-up, 0 where they are too small to be one."""
    return tuple(np.where(np.abs(values) < SIZES[0], 0.0, values).tolist())


def pressure_law(highest: float, gain: float, margin: float) -> PressureLaw:
    """A law of a gain times the pressure, of which the highest, Pa, leaves a margin of the stiffness.

    The share that is taken grows with the pressure; a vacuum takes none.
    """
    return PressureLaw((-highest, 0.0, highest), (-gain * highest, 0.0, gain * highest), (0.0, 0.0, 1 - margin))


def pressure_law_keys(pressures: Sequence[float]) -> dict[str, Key]:
    """The keys of a pressure law that is fitted to recordings at these pressures, Pa: gain and margin."""
    highest = max(pressures)

    def numbers(model: Model) -> tuple[float, float]:
        law = model.finger.pressure_law or PressureLaw((0.0, highest), (0.0, highest))
        return float(law.softening(highest)), 1 - float(law.share_taken(highest))

    def changed(model: Model, gain: float, margin: float) -> Model:
        law = pressure_law(highest, gain, margin)
        return replace(model, finger=replace(model.finger, pressure_law=law))

    def with_gain(model: Model, values: Sequence[float]) -> Model:
        return changed(model, values[0], numbers(model)[1])

    def with_margin(model: Model, values: Sequence[float]) -> Model:
        return changed(model, numbers(model)[0], values[0])

    gain = {f"{PRESSURE_LAW}.gain": Key("1", lambda model: numbers(model)[:1], with_gain)}
    margin = {f"{PRESSURE_LAW}.margin": Key("1", lambda model: numbers(model)[1:], with_margin, room=MARGINS)}
    return gain | margin if len(set(pressures)) > 1 else gain


KEYS = {
    "youngs_modulus": _of_sections("youngs_modulus", "Pa"),
    "density": _of_sections("density", "kg/m^3"),
    "chamber_width": _of_sections("chamber_width", "m"),
    "chamber_thickness": _of_sections("chamber_thickness", "m"),
    "layer_shear_modulus": _of_sections("layer_shear_modulus", "Pa"),
    "relaxation_time": _of_finger("relaxation_time", "s"),
    "length": _of_finger("length", "m"),
    "shear_factor": _of_finger("shear_factor", "1"),
    "creep.share": _of_creep("share", "1", (1e-3, 0.6)),
    "creep.time": _of_creep("time", "s", (5e-3, 100.0)),
    "mounting_x": _of_setup("mounting_x", "m", False, 1e-3),
    "mounting_z": _of_setup("mounting_z", "m", False, 1e-3),
    "mounting_angle": _of_setup("mounting_angle", "rad", False, 0.01),
    "load_x": _of_setup("load_x", "m", False, 1e-3),
    "load_z": _of_setup("load_z", "m", False, 1e-3),
    "load_friction": _of_setup("load_friction", "m", False, 1e-4, (0.0, 0.01)),
    "marker_mass": _of_setup("marker_mass", "kg", False, 1e-3, (0.0, 0.1)),
    "fill_time": _of_setup("fill_time", "s", True, 0.1, (5e-3, 1.0)),
    "swelling": _of_setup("swelling", "1", True, 0.1, (0.1, 20.0)),
    "supply_lag": _of_setup("supply_lag", "Pa", False, 300.0, (0.0, 1e5)),
    "supply_time": _of_setup("supply_time", "s", True, 0.1, (0.05, 20.0)),
    "dry_friction": _of_setup("dry_friction", "rad", False, 0.03, (0.0, 1.0)),
    "backlash": _of_setup("backlash", "m", False, 3e-4, (0.0, 0.05)),
    "delay": _of_setup("delay", "s", False, 0.05, (-2.0, 2.0)),
    "tendon.angle": _of_tendons("rad", _angle, _turned, positive=False),
    "tendon.lever": Key("m", _lever, _at_lever, room=_lever_room),
    "tendon.slack": _tendon_field("slack", "m", positive=False, scale=3e-4),
    "tendon.stiffness": _tendon_field("stiffness", "N/m", scale=0.3),
}


@dataclass(frozen=True)
class FreeParameters:
    """Chosen keys of a model, as one vector of numbers that a fit may vary."""

    model: Model
    keys: dict[str, Key]
    fixed: frozenset[str] = frozenset()  # names of numbers that stay as the model has them

    @property
    def _all_names(self) -> list[str]:
        counted = [(name, len(key.get(self.model))) for name, key in self.keys.items()]
        return [name if count == 1 else f"{name}.{i + 1}" for name, count in counted for i in range(count)]

    @property
    def _free(self) -> NDArray[np.bool_]:
        return np.array([name not in self.fixed for name in self._all_names], dtype=bool)

    def _of_numbers(self, of_key: Callable[[Key], Any]) -> list[Any]:
        """A property of every free number's key."""
        every = [of_key(key) for key in self.keys.values() for _ in key.get(self.model)]
        return [each for each, is_free in zip(every, self._free, strict=True) if is_free]

    @property
    def names(self) -> list[str]:
        """Names of all numbers; those of a key with several numbers are numbered from 1."""
        return [name for name in self._all_names if name not in self.fixed]

    @property
    def units(self) -> list[str]:
        """Units of all numbers."""
        return self._of_numbers(attrgetter("unit"))

    @property
    def scales(self) -> Array:
        """Typical changes of the vector."""
        return np.array(self._of_numbers(attrgetter("scale")))

    @property
    def is_positive(self) -> NDArray[np.bool_]:
        """Whether each number is fitted as a logarithm."""
        return np.array(self._of_numbers(attrgetter("positive")), dtype=bool)

    @property
    def start(self) -> Array:
        """The vector of the current model."""
        values = np.array([value for key in self.keys.values() for value in key.get(self.model)])[self._free]
        return np.where(self.is_positive, np.log(np.where(self.is_positive, values, 1.0)), values)

    def starts(self, count: int, seed: int, jitter: float) -> Array:
        """Vectors from which a fit may begin, (count, P): that of the current model, and random ones about it.

        `jitter` is the standard deviation of the random ones, in typical changes.
        """
        away = np.random.default_rng(seed).normal(size=(count, len(self.start))) * jitter * self.scales
        away[0] = 0.0
        return self.start + away

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the vector."""
        rooms = self._of_numbers(lambda key: key.room(self.model) if callable(key.room) else key.room)
        room = np.array(rooms).reshape(-1, 2).T
        with np.errstate(divide="ignore", invalid="ignore"):
            lower, upper = np.where(self.is_positive, np.log(np.maximum(room, 0.0)), room)
        return lower, upper

    def steps(self, x: Array, share: float) -> Array:
        """Steps from a vector for finite differences, a share of the typical changes; back where none leads on."""
        steps, (_, upper) = share * self.scales, self.bounds
        for i, moved in enumerate(x + np.diag(steps)):
            if moved[i] > upper[i] or not self._is_possible(moved):
                steps[i] *= -1
        return steps

    def _is_possible(self, x: Array) -> bool:
        try:
            self.at(x)
        except InputError:
            return False
        return True

    def values(self, x: Array) -> Array:
        """The numbers of a vector, in their units."""
        return np.where(self.is_positive, np.exp(np.where(self.is_positive, x, 0.0)), x)

    def at(self, x: Array) -> Model:
        """The model with the values of a vector.

        Raises:
            InputError: if such a finger is impossible.
        """
        numbers = np.array([value for key in self.keys.values() for value in key.get(self.model)], dtype=float)
        numbers[self._free] = self.values(x)
        model, rest = self.model, numbers.tolist()
        for key in self.keys.values():
            count = len(key.get(self.model))
            model, rest = key.put(model, rest[:count]), rest[count:]
        return model

    def fixing(self, x: Array, names: Iterable[str]) -> "FreeParameters":
        """These at a vector, of which the numbers of these names are no longer free."""
        return replace(self, model=self.at(x), fixed=self.fixed | frozenset(names))


R = TypeVar("R")  # a kind of recordings


@dataclass(frozen=True)
class FingerFit(Fit[Model], Generic[R]):
    """Free parameters fitted to recordings; events and placements of these follow them."""

    free: FreeParameters
    recordings: tuple[R, ...]  # with what was not recorded, as fitted


def free_parameters(
    finger: Finger, names: Sequence[str], pressures: Sequence[float], setup: Setup | None = None
) -> FreeParameters:
    """The parameters of a finger to be fitted.

    Args:
        finger: initial guess of the fit.
        names: names of the keys.
        pressures: pressures of the recordings, Pa; may be empty.
        setup: initial guess of the set-up; None: the default.

    Raises:
        InputError: if there is no such key, it is given twice, or the finger does not have it.
    """
    law = pressure_law_keys(pressures) if pressures else {}
    model, keys = Model(finger, replace(setup or Setup(), held_pose=HELD_POSE in names)), dict[str, Key]()
    for name in names:
        if list(names).count(name) > 1:
            raise InputError("identify", "--free", name, "appears more than once")
        if name == HELD_POSE:
            continue
        of_name = law if name == PRESSURE_LAW else {name: KEYS[name]} if name in KEYS else {}
        if not of_name:
            why = "the recordings have no pressure to fit it to" if name == PRESSURE_LAW else "there is no such key"
            known = ", ".join([*KEYS, HELD_POSE, *([PRESSURE_LAW] if law else [])])
            raise InputError("identify", "--free", name, f"{why}; known: {known}")
        for key in of_name.values():
            values = key.get(model)
            if not len(values) or (key.positive and not min(values) > 0):
                expected = "the finger file has no initial guess for it; add one there"
                raise InputError("identify", "--free", name, expected)
        keys |= of_name
    require(len(keys) > 0, "identify", "--free", " ".join(names), "name a key of the finger or its set-up as well")
    return FreeParameters(model, keys)
