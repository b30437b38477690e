"""Sensors and estimators by name: those of this project, and a user's own as "module:function".

A sensor is a system with an input `joint_angles` (N) rad and an output `strain`, the readings; whatever else it puts
out is logged. It may also take `pressure` and `X_WB`. It is made by a function of the sensors on the finger and the
period of their samples, s:

    def make(layout: SensorLayout, period: float) -> System

An estimator is a system with an output `estimated_joint_angles` (N) rad, see `FingerShape`. It may take the outputs of
the sensor, `pressure`, `X_WB`, and what drives the finger as it is believed to be, `driving_torque` (N) N m. It is made
from sensors and finger as they are believed to be, gravity in the world, m/s^2 (zero without
`estimator.compensate_gravity`), and the period:

    def make(layout: SensorLayout, gravity: Array, period: float) -> System

`module:function` is imported from Python's path and the current folder, not from the folder of the scenario: a
scenario from a stranger cannot bring code of its own.
"""

import importlib
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydrake.systems.framework import System

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, described
from soft_gripper.estimators.arc_estimator import ArcPoseEstimator
from soft_gripper.estimators.recursive import RecursiveEstimator, RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_sensor import StrainSensor

MakeSensor = Callable[[SensorLayout, float], System]
MakeEstimator = Callable[[SensorLayout, Array, float], System]

_IN_USE = "_soft_gripper_in_use"  # attribute of a block that is part of a diagram
SENSORS: dict[str, MakeSensor] = {"strain": StrainSensor}


def find_sensor(name: str) -> MakeSensor:
    """The sensor that `sensor.type` names.

    Raises:
        InputError: if there is none.
    """
    found: MakeSensor = _find("sensor.type", name, SENSORS)
    return found


def find_estimator(name: str, uncertainty: Uncertainty | None = None, field: str = "estimator.type") -> MakeEstimator:
    """The estimator of a name.

    Args:
        name: of one of this project, or "module:function".
        uncertainty: for those of this project that weigh what they know; None: the defaults.
        field: of a scenario, that names it.

    Raises:
        InputError: if there is none.
    """
    own: dict[str, MakeEstimator] = {kind: _of_function(kind, uncertainty or Uncertainty()) for kind in SHAPE_FUNCTIONS}
    own["arcs"] = lambda layout, gravity, period: ArcPoseEstimator(layout, gravity)
    found: MakeEstimator = _find(field, name, own)
    return found


def _of_function(kind: str, uncertainty: Uncertainty) -> MakeEstimator:
    """A block around an estimator that is a function of arrays."""

    def make(layout: SensorLayout, gravity: Array, period: float) -> System:
        function = SHAPE_FUNCTIONS[kind](layout, uncertainty, period)
        if isinstance(function, RecursiveShape):
            return RecursiveEstimator(function, gravity)
        return ShapeEstimator(function, layout, gravity)

    return make


def make_block(field: str, name: str, make: Callable[..., System], *arguments: Any) -> System:
    """The block that a function makes of its arguments.

    Args:
        field: of a scenario, or option, that names the function.
        name: of a block of this project, or a user's "module:function", see `name_of`.
        make: the function.
        arguments: of it.

    Raises:
        InputError: if it fails, or makes no system, or a block that it has made before.
    """
    with seen_from(field, name):
        try:
            block = make(*arguments)
        except InputError:
            raise
        except (Exception, SystemExit) as error:  # whatever a user's function may raise
            raise InputError("scenario", field, name, f"failed: {described(error)}") from error
    if not isinstance(block, System):
        raise InputError("scenario", field, name, f"made a {type(block).__name__}; a Drake System is needed")
    if hasattr(block, _IN_USE):
        raise InputError("scenario", field, name, "returned the same block twice; make a new one for every finger")
    setattr(block, _IN_USE, True)
    return block


@contextmanager
def seen_from(field: str, name: str) -> Iterator[None]:
    """Where something is wrong with a user's own block, the InputError names the function that made it."""
    try:
        yield
    except InputError as error:
        if not is_own(name):
            raise
        raise error.inside(f"{field} = {name}") from error.__cause__


def is_own(name: str) -> bool:
    """Whether a name is that of a user's function."""
    return ":" in name


def name_of(make: Callable[..., System] | None, type_name: str) -> str:
    """What a block is called in tables, recordings and messages: a user's function, or the type of a scenario."""
    return type_name if make is None else f"{make.__module__}:{getattr(make, '__qualname__', repr(make))}"


def find_function(field: str, name: str) -> Callable[..., Any]:
    """A user's function, "module:function", that an option or a field names.

    Raises:
        InputError: if it cannot be imported, or is not callable.
    """
    if not is_own(name):
        raise InputError("scenario", field, name, 'give "module:function"')
    found: Callable[..., Any] = _find(field, name, {})
    return found


def _find(field: str, name: str, known: Mapping[str, Any]) -> Any:
    if name in known:
        return known[name]
    module, colon, function = name.partition(":")
    if not colon or not module or not function:
        raise InputError("scenario", field, name, f'known: {", ".join(known)}; or give "module:function" of your own')
    try:
        made = getattr(_import(module), function)
    except (Exception, SystemExit) as error:  # whatever a user's module may raise
        where = f"looked where Python looks, and in {Path.cwd()}"
        raise InputError("scenario", field, name, f"cannot be imported: {described(error)}; {where}") from error
    if not callable(made):
        raise InputError("scenario", field, name, "is not callable")
    return made


def _import(module: str) -> Any:
    """A module; the current folder is looked through last."""
    here = str(Path.cwd())
    sys.path.append(here)
    try:
        return importlib.import_module(module)
    finally:
        sys.path.remove(here)
