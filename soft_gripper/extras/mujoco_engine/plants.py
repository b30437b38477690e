"""Copies of a plant in MuJoCo, with the ports of Drake's plant; environments are the leading axis of every array.

The copies are those of stations of one structure, whose objects may differ. E environments, nq positions and nv
velocities in the order of Drake's plant, in which a free body has [q_w .. z] and [angular, linear] velocities in the
world; MuJoCo has the position first, and the angular velocity in the body.
"""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping, Sequence
from functools import cache, cached_property
from itertools import accumulate
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, JointActuator, ModelInstanceIndex

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, first_line
from soft_gripper.extras.export.actuation import arm_actuators
from soft_gripper.extras.export.mjcf import station_mjcf
from soft_gripper.extras.export.tree import scoped_name
from soft_gripper.extras.mujoco_engine.blocks import Rows
from soft_gripper.extras.mujoco_engine.library import load_mujoco
from soft_gripper.extras.mujoco_engine.normal_forces import NormalForces
from soft_gripper.extras.mujoco_engine.touching import TouchSensors
from soft_gripper.extras.mujoco_engine.variation import PairIds
from soft_gripper.fingers.spatial_chain import vector_product

if TYPE_CHECKING:  # it is optional
    import mujoco


class Layout:
    """Indices in MuJoCo of the positions, velocities and actuators of Drake's plant."""

    def __init__(self, plant: MultibodyPlant, model: "mujoco.MjModel"):
        self.plant = plant
        self.qpos, self.qvel = np.zeros(plant.num_positions(), int), np.zeros(plant.num_velocities(), int)
        self.turns: list[tuple[slice, slice]] = []  # of free bodies: their quaternions and angular velocities
        for joint in map(plant.get_joint, plant.GetJointIndices()):
            if not joint.num_velocities():
                continue
            mujoco_joint = model.joint(scoped_name(joint))
            q, v, q_start, v_start = joint.position_start(), joint.velocity_start(), *_dof_starts(mujoco_joint)
            if joint.num_velocities() == 1:
                self.qpos[q], self.qvel[v] = q_start, v_start
                continue
            self.qpos[q : q + 7] = q_start + np.array([3, 4, 5, 6, 0, 1, 2])
            self.qvel[v : v + 6] = v_start + np.array([3, 4, 5, 0, 1, 2])
            self.turns.append((slice(q, q + 4), slice(v, v + 3)))

    def state(self, qpos: Array, qvel: Array) -> Array:
        """The state of Drake's plant, (E, nq + nv)."""
        q = qpos[:, self.qpos]
        return np.concatenate([q, self.to_world(q, qvel)], axis=1)

    def to_world(self, q: Array, vector: Array) -> Array:
        """Converts velocities, or forces along them, of MuJoCo to the order and frames of Drake's plant, (E, nv)."""
        velocities = vector[:, self.qvel]
        for quaternion, angular in self.turns:
            velocities[:, angular] = _rotate(q[:, quaternion], velocities[:, angular])
        return velocities

    def dofs(self, model: ModelInstanceIndex) -> NDArray[np.int_]:
        """The degrees of freedom of the actuators of a model in MuJoCo, in their order in Drake."""
        joints = [actuator.joint() for actuator in actuators(self.plant, model)]
        return self.qvel[[joint.velocity_start() for joint in joints]]

    def velocities(self, model: ModelInstanceIndex) -> NDArray[np.int_]:
        """The velocities of a model among those of the plant."""
        return self.plant.GetVelocitiesFromArray(model, np.arange(self.plant.num_velocities())).astype(int)

    def positions(self, model: ModelInstanceIndex) -> NDArray[np.int_]:
        """The positions of a model among those of the plant."""
        return self.plant.GetPositionsFromArray(model, np.arange(self.plant.num_positions())).astype(int)


def _dof_starts(joint: Any) -> tuple[int, int]:
    return int(joint.qposadr[0]), int(joint.dofadr[0])


def _rotate(quaternion: Array, vector: Array) -> Array:
    """Rotates vectors, (E, 3), by unit quaternions [w, x, y, z], (E, 4)."""
    w, axis = quaternion[:, :1], quaternion[:, 1:]
    cross = vector_product(axis, vector)
    return vector + 2 * (w * cross + vector_product(axis, cross))


def _value(model: "mujoco.MjModel", name: str) -> Array:
    """A field of a model, or of its options, by its name in a batch."""
    owner, _, option = name.rpartition(".")
    return np.asarray(getattr(model.opt if owner else model, option))


def actuators(plant: MultibodyPlant, model: ModelInstanceIndex) -> list[JointActuator]:
    """The actuators of a model, in their order."""
    return [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices(model)]


_STAGE_NONE = 0  # mjSTAGE_NONE: nothing is computed
_DISABLE_SENSORS = 1 << 13  # mjDSBL_SENSOR


class _Arm(NamedTuple):
    """The position actuators of an arm, in the order of Drake's actuators."""

    ctrl_indices: NDArray[np.int_]
    stiffness: Array
    damping: Array


class Exported(NamedTuple):
    """A station in MuJoCo."""

    model: "mujoco.MjModel"
    pairs: PairIds
    touching: TouchSensors | NormalForces


def export_to_mujoco(
    station: Station,
    step: float,
    paired_models: Collection[str] = (),
    sensors: TouchSensors | NormalForces | None = None,
) -> Exported:
    """Exports a station to MuJoCo, without the drive of its fingers.

    Args:
        station: made with contact at points.
        step: of MuJoCo, s.
        paired_models: models that touch others in pairs, see `station_mjcf`.
        sensors: sensors of contact; None: those for recordings.

    Raises:
        InputError: as `load_mujoco` and `station_mjcf`, or if MuJoCo refuses the models.
    """
    load_mujoco()
    import mujoco

    # The integrator implicitfast lets slender links that touch chatter, in steps of 0.5 ms too.
    export = station_mjcf(station, step, False, paired_models)
    root = ET.fromstring(export.text)
    arm = {scoped_name(actuator.joint) for actuator in arm_actuators(station)}
    for tag in ("tendon", "keyframe"):
        root.remove(_part(root, tag))
    actuator_element = _part(root, "actuator")
    for actuator in [element for element in actuator_element if element.attrib["name"] not in arm]:
        actuator_element.remove(actuator)
    sensors = sensors or TouchSensors(station)
    sensors.add_to(root)
    assets = {f"meshes/{name}": path.read_bytes() for name, path in export.meshes.items()}
    try:
        model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"), assets)
    except ValueError as error:
        reason = f"MuJoCo cannot read the models: {first_line(error)}"
        raise InputError("scenario", "engine", "mujoco", reason) from None
    disable_bits = mujoco.mjtDisableBit
    model.opt.disableflags |= disable_bits.mjDSBL_AUTORESET  # a diverged state is reported, not replaced
    model.opt.disableflags |= disable_bits.mjDSBL_ISLAND  # slower, as few objects do not touch each other
    sensors.bind(model)
    if _touches_only_in_pairs(model):
        model.geom_contype[:] = model.geom_conaffinity[:] = 0  # or MuJoCo would search for others at every step
    pairs: dict[Any, list[int]] = {}
    for pair in export.pairs:
        pairs.setdefault((pair.models, pair.surfaces), []).append(int(model.pair(pair.name).id))
    return Exported(model, pairs, sensors)


def _touches_only_in_pairs(model: "mujoco.MjModel") -> bool:
    """Whether all shapes that touch are listed as pairs."""
    bits = (model.geom_contype[:, None] & model.geom_conaffinity) != 0
    may_touch = bits | bits.T
    may_touch[model.pair_geom1, model.pair_geom2] = may_touch[model.pair_geom2, model.pair_geom1] = False
    np.fill_diagonal(may_touch, val=False)
    return not may_touch.any()


def _part(root: ET.Element, name: str) -> ET.Element:
    element = root.find(name)
    assert element is not None
    return element


class Plants:
    """Plants of E runs of stations that differ in their objects alone."""

    def __init__(
        self,
        station: Station,
        touching: TouchSensors | NormalForces,
        models: "Sequence[mujoco.MjModel]",
        begins: Array,
        threads: int = 1,
        is_one_file: bool = True,
    ):
        """
        Args:
            station: the first one.
            touching: its sensors of contact.
            models: of all stations, in MuJoCo, with steps that divide those of Drake's plant.
            begins: positions at the beginning of the runs, (E, nq).
            threads: number of threads that step them.
            is_one_file: whether the models were read from one file, and numbers were changed, see `varied`.
        """
        from mujoco import mjtState, mjtWarning
        from mujoco.batch import Batch

        self._own_fields = set[str]()  # names of fields of the model that differ between environments
        substeps = np.array([round(station.plant.time_step() / model.opt.timestep) for model in models])
        self._rows_by_substeps = [(int(count), np.flatnonzero(substeps == count)) for count in np.unique(substeps)]
        self.station, self.touching = station, touching
        self.plant, self.layout, self._model = station.plant, Layout(station.plant, models[0]), models[0]
        self.batch = Batch(models[0], len(models), threads)
        if is_one_file:
            self._set_models(np.arange(len(models)), models)
        else:
            self.batch.set_models(models)
        self._flags = self.batch.expand("opt.disableflags") if is_one_file else None
        self._qpos, self._qvel = self.batch.bind("qpos"), self.batch.bind("qvel")
        self._applied, self._ctrl = self.batch.bind("qfrc_applied"), self.batch.bind("ctrl")
        self._contact, self._driven = self.batch.bind("qfrc_constraint"), self.batch.bind("qfrc_actuator")
        self._xpos, self._xmat = self.batch.bind("xpos"), self.batch.bind("xmat")
        self._sensed = self.batch.bind("sensordata")
        self._driving = int(mjtState.mjSTATE_CTRL | mjtState.mjSTATE_QFRC_APPLIED)
        warnings = mjtWarning.mjWARN_BADQPOS, mjtWarning.mjWARN_BADQVEL, mjtWarning.mjWARN_BADQACC
        self._divergence_warnings = [*map(int, warnings)]
        self._scheduled, self._readings = list[Array](), list[Array]()  # (E, nu + nv) for each step; (E, K, sensors)
        self._qpos[:, self.layout.qpos] = begins
        self.batch.forward()
        self.active = np.arange(len(models))
        self._dofs = cache(self.layout.dofs)
        self._state: Array | None = None
        self._forces: Array | None = None  # of the contacts, once they are read
        self.look()

    def reset(self, rows: Rows, models: "Sequence[mujoco.MjModel]", begins: Array) -> None:
        """Restarts some environments with their models, (rows,), and positions, (rows, nq)."""
        self._set_models(rows, models)
        self.batch.reset(rows, stage=_STAGE_NONE)
        places = np.ix_(rows, self.layout.qpos)
        self._qpos[places] = begins
        self.batch.forward(rows)

    def _set_models(self, rows: Rows, models: "Sequence[mujoco.MjModel]") -> None:
        """Sets the models of some environments; only differing fields are stored, to save memory."""
        for row, model in zip(rows, models, strict=True):
            for name, default in self._default_fields.items():
                value = _value(model, name)
                if name in self._own_fields or value.tobytes() != default:
                    self._own_fields.add(name)
                    self.batch.expand(name)[row] = value

    @cached_property
    def _default_fields(self) -> dict[str, bytes]:
        """Fields of the model that may differ between environments, as bytes; integers are structure and may not."""
        from mujoco.batch import MODEL_FIELDS

        values = {name: _value(self._model, name) for name in MODEL_FIELDS}
        return {name: value.tobytes() for name, value in values.items() if value.size and value.dtype.kind == "f"}

    @cached_property
    def _arm(self) -> _Arm | None:
        arm = self.station.parts.arm
        if arm is None:
            return None
        gains = {actuator.joint.name(): actuator for actuator in arm_actuators(self.station)}
        joints: list[Joint] = [actuator.joint() for actuator in actuators(self.plant, arm.model)]
        ctrl = np.array([self._model.actuator(scoped_name(joint)).id for joint in joints])
        arm_gains = [gains[joint.name()] for joint in joints]
        stiffness, damping = ([getattr(actuator, name) for actuator in arm_gains] for name in ("stiffness", "damping"))
        return _Arm(ctrl, np.array(stiffness), np.array(damping))

    def drive(self, model: ModelInstanceIndex, torques: Array, desired: Array | None) -> None:
        """Applies efforts of a model's actuators, (E, nu) N m or N, and the desired states of an arm, (E, 2 nu)."""
        arm = self._arm
        if self.station.parts.arm is None or model != self.station.parts.arm.model:
            self._applied[:, self._dofs(model)] = torques
        elif arm is not None and desired is not None:
            position, velocity = desired[:, : len(arm.ctrl_indices)], desired[:, len(arm.ctrl_indices) :]
            self._ctrl[:, arm.ctrl_indices] = position + (torques + arm.damping * velocity) / arm.stiffness

    def schedule(self) -> None:
        """Schedules a step of Drake's plant, driven as now."""
        self._scheduled.append(np.concatenate([self._ctrl, self._applied], axis=1))

    def step(self, keeps: bool = False) -> None:
        """Makes all scheduled steps; contacts are unknown unless it `keeps` them."""
        self._make(len(self._scheduled), 0, keeps)
        self._scheduled.clear()

    def begin_step(self, keeps: bool = False) -> None:
        """Makes the first substep of a step of Drake's plant; it may keep the contacts.

        Values that follow from the state are then those of the state before.
        """
        self._sense(True)
        self.batch.step(self.active, 1)
        self._forces = None
        if keeps:
            self._readings.append(self._sensed[:, None].copy())

    def finish_step(self, keeps: bool = False) -> None:
        """Makes the other substeps; contacts are those in the first, unless it `keeps` others."""
        self._make(1, 1, keeps)

    def _make(self, steps: int, substeps_done: int, keeps: bool) -> None:
        """Makes steps of Drake's plant, after `substeps_done` steps of MuJoCo."""
        self._sense(keeps)
        self._forces = None
        for substeps, rows in self._rows_by_substeps:
            active = self.active if len(self._rows_by_substeps) == 1 else np.intersect1d(rows, self.active)
            steps_left = steps * substeps - substeps_done
            if not steps_left or not len(active):
                continue
            if steps == 1 and not keeps:
                self.batch.step(active, steps_left)
                continue
            controls = [commands[active] for commands in self._scheduled for _ in range(substeps)]
            control, recorded_fields = np.stack(controls, axis=1) if controls else None, ["sensordata"] if keeps else []
            self._readings += self.batch.rollout(steps_left, control, self._driving, recorded_fields, active).values()
            has_diverged = self.batch.warning[:, self._divergence_warnings, 1].any(axis=1)
            self._qvel[has_diverged] = np.nan  # the rollout stops there

    def _sense(self, senses: bool) -> None:
        """Turns the computation of contact sensors on or off; it takes a tenth of a step."""
        if self._flags is not None:
            flags = int(self._model.opt.disableflags)
            self._flags[:] = flags if senses else flags | _DISABLE_SENSORS

    def look(self) -> None:
        """Copies the present states."""
        self._viewed, self._state = (self._qpos.copy(), self._qvel.copy()), None
        self._forces = None

    @property
    def state(self) -> Array:
        """States of Drake's plants at the last `look`, (E, nq + nv)."""
        if self._state is None:
            self._state = self.layout.state(*self._viewed)
        return self._state

    def contact_forces(self) -> Array:
        """Generalized forces of all contacts, (E, nv)."""
        if self._forces is None:
            self._forces = self.layout.to_world(self.state[:, : self.plant.num_positions()], self._contact)
        return self._forces

    def net_actuation(self, model: ModelInstanceIndex) -> Array:
        """Torques that the actuators of an arm apply, (E, nu)."""
        return np.array(self._driven[:, self._dofs(model)])

    def pose(self, body: Any) -> Array:
        """The pose of a body of Drake's plant in the world, (E, 3, 4) [R | p]."""
        body_id = self._model.body(str(self.plant.get_body(body).scoped_name())).id
        return np.concatenate([self._xmat[:, body_id].reshape(-1, 3, 3), self._xpos[:, body_id, :, None]], axis=-1)

    def patches(self) -> tuple[Array, NDArray[np.int_]]:
        """Contacts of all fingers as rows of `patch_table`, and where those of each environment begin, (E + 1,)."""
        assert isinstance(self.touching, TouchSensors)
        return self.touching.read(self._sensed, self._xpos, self._xmat)

    def take_readings(self, stride: int) -> Array:
        """Returns and clears the contact readings kept since the last call, (E, K, n).

        They are those of each `stride`-th step, from the first on, and of the last one.
        """
        begins = accumulate((readings.shape[1] for readings in self._readings[:-1]), initial=0)
        pieces = [reading[:, -begin % stride :: stride] for reading, begin in zip(self._readings, begins, strict=True)]
        kept_readings = np.concatenate([*pieces, self._readings[-1][:, -1:]], axis=1)
        self._readings.clear()
        return kept_readings

    def model_ports(self, model: ModelInstanceIndex) -> Mapping[str, Any]:
        """Functions that compute a model's output ports, by port name without the model's."""
        q, v = self.layout.positions(model), self.layout.velocities(model)
        state_indices = np.concatenate([q, self.plant.num_positions() + v])
        return {
            "state": lambda: self.state[:, state_indices],
            "generalized_contact_forces": lambda: self.contact_forces()[:, v],
            "net_actuation": lambda: self.net_actuation(model),
        }
