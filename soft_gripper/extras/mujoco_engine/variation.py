"""Keys of stations, plants and blocks that runs in MuJoCo share, and changes of models between runs.

A scenario gives a `Key`, equal where runs share. `variation` compares it with the scenario of the shared station:
`begin_positions` takes poses from the result, and `vary_model` masses, kg, frictions, factors of size, and stiffnesses,
N/m. Another difference is a field of `Variation`.

Pose, mass and friction of free objects are numbers in MuJoCo's model and state, and a task is planned anew for the
pose of its object, so that runs that differ in them share a station. A mesh of another size is another model: such runs
have stations of their own, and share the blocks. Runs with other pressures, set points, gains or sensor errors share
the plant, of which each station has a copy. Runs whose diagrams have one structure are stepped together in any case.
"""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import build_key, fingerprint
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
PairIds = Mapping[tuple[tuple[str, str], tuple[ShapeSurface, ShapeSurface]], list[int]]  # by models and surfaces
_ANY_FILE = "package://soft_gripper/package.xml"  # instead of the file of an object


Content = Callable[[Path], str | None]


def station_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Key that is equal for scenarios of one station; None: no other scenario has this station, see `build_key`."""
    plain_scenario = plain_objects(scenario)
    models = [replace(model, X_PC=Transform()) if model.free else model for model in plain_scenario.models]
    return build_key(replace(plain_scenario, description="", models=models, task=_clear_places(scenario)), content_of)


def plain_objects(scenario: Scenario) -> Scenario:
    """Scenario of the station that serves a scenario: given masses and frictions of free objects are set in MuJoCo.

    They are 1 here, so that a run does not depend, even in rounding, on the scenario that a station was first made for.
    """
    models = [_with_unit_properties(model) if model.free else model for model in scenario.models]
    return replace(scenario, models=models)


def plant_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Key that is equal for scenarios with equal plants, except poses of free objects; None: no plant is equal."""
    plain_scenario = plain_objects(scenario)
    models = [replace(model, X_PC=Transform()) if model.free else model for model in plain_scenario.models]
    fields: dict[str, Any] = {"sensor": SensorConfig(), "estimator": EstimatorConfig(), "pressure": PressureConfig()}
    fields |= {"tendons": TendonConfig(), "control": ControlConfig(), "task": None, "external": [], "success": []}
    return build_key(replace(plain_scenario, description="", models=models, **fields), content_of)


def blocks_key(scenario: Scenario, content_of: Content = fingerprint) -> Key | None:
    """Key that is equal for stations with equal blocks, except phases of tasks; None: no other station has them."""
    any_object = partial(ModelConfig, file=_ANY_FILE, free=True)
    models = [any_object(name=model.name) if model.free else model for model in scenario.models]
    files = repr([model.file for model in scenario.models if model.free])  # their contents need not be known
    plain_scenario = replace(scenario, description=files, models=models, task=_clear_places(scenario))
    return build_key(plain_scenario, content_of)


def _clear_places(scenario: Scenario) -> TaskConfig | None:
    """Task of a scenario, without the poses between which it carries an object."""
    task = scenario.task
    return None if task is None else replace(task, X_WGoal=Transform(), pose_error=PoseErrorConfig())


def _with_unit_properties(model: ModelConfig) -> ModelConfig:
    mass, friction = (None if value is None else 1.0 for value in (model.mass, model.friction))
    return replace(model, mass=mass, friction=friction)


@dataclass(frozen=True)
class Variation:
    """Differences of a scenario's objects from those of the station that serves it, by the names of models."""

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
    """Differences of a scenario from another one with the same `station_key`."""
    poses, masses, frictions = {}, {}, {}
    for model, base_model in zip(scenario.models, base.models, strict=True):
        if model.free:
            X, X_base = (config.X_PC.GetDeterministicValue() for config in (model, base_model))
            if not X.IsExactlyEqualTo(X_base):
                poses[model.name] = X
            if model.mass is not None and model.mass != base_model.mass:
                masses[model.name] = model.mass
            if model.friction is not None and model.friction != base_model.friction:
                frictions[model.name] = model.friction
    return Variation(poses, masses, frictions)


def begin_positions(plant: MultibodyPlant, differences: Variation) -> Array:
    """Positions at the beginning of a run, (nq,)."""
    q = np.array(plant.GetDefaultPositions())
    for name, X_WB in differences.poses.items():
        body = plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(name))[0])
        start = body.floating_positions_start()
        q[start : start + 7] = [*X_WB.rotation().ToQuaternion().wxyz(), *X_WB.translation()]
    return q


def vary_model(
    model: "mujoco.MjModel", pairs: PairIds, plant: MultibodyPlant, differences: Variation, points: int
) -> "mujoco.MjModel":
    """Copies a model of MuJoCo with other objects; inertia grows with the mass, and with the square of the size.

    Args:
        model: in which the models that differ touch others in pairs.
        pairs: its pairs.
        plant: of Drake.
        differences: of its objects.
        points: on either side of a link.
    """
    if not differences.touched:
        return model
    varied_model, growth = copy(model), {}
    for name in {*differences.masses, *differences.sizes}:
        bodies = [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName(name))]
        mass, size = sum(body.default_mass() for body in bodies), differences.sizes.get(name, 1.0)
        growth[name] = differences.masses.get(name, mass) / mass
        for body_id in (varied_model.body(str(body.scoped_name())).id for body in bodies):
            varied_model.body_mass[body_id] *= growth[name]
            varied_model.body_inertia[body_id] *= growth[name] * size**2
            varied_model.body_ipos[body_id] *= size
            for lengths in (
                varied_model.geom_size,
                varied_model.geom_pos,
                varied_model.geom_rbound,
                varied_model.geom_aabb,
            ):
                lengths[varied_model.geom_bodyid == body_id] *= size
    if growth:
        import mujoco

        mujoco.mj_setConst(varied_model, mujoco.MjData(varied_model))
    for (models, surfaces), ids in pairs.items():
        if differences.touched.intersection(models):
            friction, time = _contact(models, surfaces, differences, growth, points)
            varied_model.pair_friction[ids], varied_model.pair_solref[ids, 0] = friction, time
    return varied_model


def _contact(
    models: tuple[str, str],
    surfaces: tuple[ShapeSurface, ShapeSurface],
    differences: Variation,
    growth: Mapping[str, float],
    points: int,
) -> tuple[list[float], float]:
    """Friction coefficients and time constant, s, of a pair of shapes of changed models."""
    first_contact, second = (
        ShapeSurface(
            differences.frictions.get(name, surface.friction),
            1 / differences.stiffnesses[name] if name in differences.stiffnesses else surface.compliance,
            surface.mobility / growth.get(name, 1.0),
        )
        for name, surface in zip(models, surfaces, strict=True)
    )
    contact = touch(first_contact, second)
    return friction_coefficients(contact, 2, points), contact.time
