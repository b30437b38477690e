"""Runs in MuJoCo may share one station, one model, or the blocks around models of their own.

Pose, mass and friction of free objects are numbers in MuJoCo's model and state, and a task is planned anew for the
pose of its object, so that runs that differ in them share a station. A mesh of another size is another model: such runs
have stations of their own, and share the blocks. Runs with other pressures, set points, gains or sensor errors share
the plant, of which each station has a copy. Runs whose diagrams have one structure are stepped together in any case.
"""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import build_key, fingerprint
from soft_gripper.extras.export.mjcf import Mjcf
from soft_gripper.extras.export.mjcf_contact import ShapeSurface, friction_coefficients, touch
from soft_gripper.scenario.schema import (
    ControlConfig,
    EstimatorConfig,
    ModelConfig,
    PoseErrorConfig,
    PressureConfig,
    Scenario,
    SensorConfig,
    TaskConfig,
    TendonConfig,
)

if TYPE_CHECKING:  # it is optional
    import mujoco

Key = tuple[str, ...]
_ANY = "package://soft_gripper/package.xml"  # in the place of the file of an object


Content = Callable[[Path], str | None]


def station_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Equal for scenarios that one station serves; None: it serves no other, see `build_key`."""
    plain = plain_objects(scenario)
    models = [replace(each, X_PC=Transform()) if each.free else each for each in plain.models]
    return build_key(replace(plain, description="", models=models, task=_without_places(scenario)), content_of)


def plain_objects(scenario: Scenario) -> Scenario:
    """The scenario of a station that serves a scenario: given masses and frictions of free objects are set in MuJoCo.

    They are 1, so that a run does not depend, not even in its rounding, on the one that a station was first made for.
    """
    models = [_plain(model) if model.free else model for model in scenario.models]
    return replace(scenario, models=models)


def plant_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Equal for scenarios with equal plants, but for poses of free objects; None: no other has."""
    plain = plain_objects(scenario)
    models = [replace(model, X_PC=Transform()) if model.free else model for model in plain.models]
    parts: dict[str, Any] = {"sensor": SensorConfig(), "estimator": EstimatorConfig(), "pressure": PressureConfig()}
    parts |= {"tendons": TendonConfig(), "control": ControlConfig(), "task": None, "external": [], "success": []}
    return build_key(replace(plain, description="", models=models, **parts), content_of)


def blocks_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Equal for scenarios whose stations have equal blocks, but for the phases of their tasks; None: no other has."""
    models = [ModelConfig(name=model.name, file=_ANY, free=True) if model.free else model for model in scenario.models]
    files = repr([model.file for model in scenario.models if model.free])  # their contents need not be known
    built = replace(scenario, description=files, models=models, task=_without_places(scenario))
    return build_key(built, content_of)


def _without_places(scenario: Scenario) -> TaskConfig | None:
    """The task of a scenario, whatever the places between which it carries an object."""
    task = scenario.task
    return None if task is None else replace(task, X_WGoal=Transform(), pose_error=PoseErrorConfig())


def _plain(model: ModelConfig) -> ModelConfig:
    mass, friction = (None if given is None else 1.0 for given in (model.mass, model.friction))
    return replace(model, mass=mass, friction=friction)


@dataclass(frozen=True)
class Variation:
    """How the objects of a scenario differ from those of the station that serves it; by the names of models."""

    poses: Mapping[str, RigidTransform] = field(default_factory=dict)
    masses: Mapping[str, float] = field(default_factory=dict)  # kg
    frictions: Mapping[str, float] = field(default_factory=dict)
    sizes: Mapping[str, float] = field(default_factory=dict)  # factors of all lengths
    stiffnesses: Mapping[str, float] = field(default_factory=dict)  # N/m, at a point of contact

    @property
    def touched(self) -> set[str]:
        """Models whose contacts differ."""
        return {*self.masses, *self.frictions, *self.sizes, *self.stiffnesses}


def variation(scenario: Scenario, base: Scenario) -> Variation:
    """How a scenario differs from another one with the same `station_key`."""
    poses, masses, frictions = {}, {}, {}
    for model, other in zip(scenario.models, base.models, strict=True):
        if model.free:
            X, X_base = (each.X_PC.GetDeterministicValue() for each in (model, other))
            if not X.IsExactlyEqualTo(X_base):
                poses[model.name] = X
            if model.mass is not None and model.mass != other.mass:
                masses[model.name] = model.mass
            if model.friction is not None and model.friction != other.friction:
                frictions[model.name] = model.friction
    return Variation(poses, masses, frictions)


def begin(plant: MultibodyPlant, of: Variation) -> Array:
    """The positions in which a run begins, (nq,)."""
    q = np.array(plant.GetDefaultPositions())
    for name, X_WB in of.poses.items():
        first = plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(name))[0])
        place = first.floating_positions_start()
        q[place : place + 7] = [*X_WB.rotation().ToQuaternion().wxyz(), *X_WB.translation()]
    return q


def varied(
    model: "mujoco.MjModel", exported: Mjcf, plant: MultibodyPlant, of: Variation, points: int
) -> "mujoco.MjModel":
    """A model of MuJoCo with other objects; inertia grows with the mass, and with the square of the size.

    Args:
        model: in which the models that differ touch others in pairs.
        exported: the file from which it was made.
        plant: of Drake.
        of: how it differs.
        points: on either side of a link.
    """
    if not of.touched:
        return model
    found, growth = copy(model), {}
    for name in {*of.masses, *of.sizes}:
        bodies = [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName(name))]
        mass, size = sum(body.default_mass() for body in bodies), of.sizes.get(name, 1.0)
        growth[name] = of.masses.get(name, mass) / mass
        for number in (found.body(str(body.scoped_name())).id for body in bodies):
            found.body_mass[number] *= growth[name]
            found.body_inertia[number] *= growth[name] * size**2
            found.body_ipos[number] *= size
            for lengths in (found.geom_size, found.geom_pos, found.geom_rbound, found.geom_aabb):
                lengths[found.geom_bodyid == number] *= size
    if growth:
        import mujoco

        mujoco.mj_setConst(found, mujoco.MjData(found))
    contact = cache(partial(_contact, of=of, growth=growth, points=points))  # many pairs are alike
    touched, friction, solref = of.touched, found.pair_friction, found.pair_solref
    for pair in exported.pairs:
        if touched.intersection(pair.models):
            number = found.pair(pair.name).id
            friction[number], solref[number, 0] = contact(pair.models, pair.surfaces)
    return found


def _contact(
    models: tuple[str, str],
    surfaces: tuple[ShapeSurface, ShapeSurface],
    of: Variation,
    growth: Mapping[str, float],
    points: int,
) -> tuple[list[float], float]:
    """Friction and time constant of a pair of shapes of two models that differ."""
    one, other = (
        ShapeSurface(
            of.frictions.get(name, surface.friction),
            1 / of.stiffnesses[name] if name in of.stiffnesses else surface.compliance,
            surface.mobility / growth.get(name, 1.0),
        )
        for name, surface in zip(models, surfaces, strict=True)
    )
    contact = touch(one, other)
    return friction_coefficients(contact, 2, points), contact.time
