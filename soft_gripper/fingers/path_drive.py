"""Drives along paths that turn with the finger: tendons, and chambers of a finger that twists.

Their torque depends on the shape, so it is computed at every step of the plant, from the gradients of the lengths of
the paths (`paths`); the chamber law of the straight finger is one matrix, see `pressure_drive`. Drake's own tendon
constraint has fixed limits and constant gradients, so a run could not pull it, nor a twist slant it.

A tendon that is commanded in length is a spring between its winch and its end, slack where it would have to push,

    T = max(0, stiffness (pulled length - slack - (l(0) - l(q)))) .

A tendon that slides over its sheath loses tension where the finger is bent (capstan): beyond the angle phi of the
bend it pulls with  T exp(-mu phi z) . z is 1 where the tendon is being pulled, -1 where it is let go, and changes over
a short travel of the tendon, so that a joint that stands still keeps its friction (Dahl, *A Solid Friction Model*,
1968).
"""

from collections.abc import Mapping

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.paths import Joints, length_gradients, path_lengths
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.steps import same

TENSION, PULL = "tension", "pull"
_FRICTION_PERIOD = 5e-3  # s, between changes of friction in a plant without steps


class Tendons:
    """The T tendons of a finger. Joint positions q are (..., N) rad, or m, by deformation."""

    def __init__(self, finger: Finger):
        tendons = finger.tendons
        self.paths = finger.tendon_paths
        self._straight = path_lengths(self.paths, {"bending": np.zeros(finger.segments)})
        self.stiffness = np.array([tendon.stiffness for tendon in tendons])  # (T,) N/m
        self._slack = np.array([tendon.slack for tendon in tendons])
        self._friction = np.array([tendon.friction for tendon in tendons])
        self._reversal = np.array([tendon.reversal for tendon in tendons])
        self.slide = bool(self._friction.any())  # against friction

    def tensions(self, q: Joints, pull: Array) -> Array:
        """Tensions of tendons at pulled-in lengths, (..., T) m -> (..., T) N."""
        return np.maximum(0.0, self.stiffness * self.elongations(q, pull))

    def elongations(self, q: Joints, pull: Array) -> Array:
        """Elongation of these tendons over their length at rest, (..., T) m; negative where they are slack."""
        return np.asarray(pull - self._slack - self._straight + path_lengths(self.paths, q))

    def torques(self, q: Joints, tensions: Array, sliding: Array | None = None) -> dict[str, Array]:
        """Torques at the joints, (..., N) N m, and N where they slide, by deformation.

        Tensions are those at the pulled ends, (..., T) N; `sliding` is z of the friction, (..., T); None: no friction.
        """
        axial_forces = -tensions[..., None]
        if sliding is not None:  # tension in the middle of every segment over that at the pulled end
            bend = np.hypot(q["bending"], q["sideways"]) if "sideways" in q else np.abs(q["bending"])
            wrap = bend[..., None, :] * self.paths.share
            angle = wrap.cumsum(axis=-1) - wrap / 2
            axial_forces = axial_forces * np.exp(-(self._friction * sliding)[..., None] * angle)
        return {name: (axial_forces * slope).sum(axis=-2) for name, slope in length_gradients(self.paths, q).items()}

    def next_sliding(self, sliding: Array, travel: Array) -> Array:
        """z of the friction after tendons travelled by (..., T) m toward their pulled ends, (..., T)."""
        direction = np.sign(travel)
        decay = np.exp(-np.abs(travel) / self._reversal)
        return np.asarray(direction + (sliding - direction) * decay)


class _PathDriveBlock(ArrayBlock):
    """Reads the joints of a finger from the state of its plant, and drives its actuators."""

    def __init__(self, finger: PlantFinger, period: float | None = None):
        super().__init__(period)
        deformations = finger.finger.yields
        self._deformations = {name: np.argmax(finger.position_selector(name), axis=-1) for name in deformations}
        self._actuators = {name: np.argmax(finger.actuator_selector(name), axis=-1) for name in deformations}
        self._finger, self._size = finger.finger, len(finger.actuator_names)
        self.take("state", finger.plant.num_multibody_states())

    def _joints(self, state: Array) -> dict[str, Array]:
        """Joint positions, (..., N) rad or m, by deformation, from a state of the plant, (..., nq + nv)."""
        return {deformation: state[..., places] for deformation, places in self._deformations.items()}

    def _actuation(self, torques: Mapping[str, Array]) -> Array:
        """Torques of joints, (..., N) each, as actuation, (..., nu)."""
        actuation = np.zeros((*next(iter(torques.values())).shape[:-1], self._size))
        for deformation, torque in torques.items():
            actuation[..., self._actuators[deformation]] = torque
        return actuation


class TendonDrive(_PathDriveBlock):
    """Turns tensions, or pulled lengths, of the tendons of a finger into torques on its joints.

    ::

        state (nq + nv) of the plant --------> +-------------+ ---> tension    (T) N, at the pulled ends
        tension (T) N, or pull (T) m, -------> | TendonDrive |
        as commanded                           +-------------+ ---> actuation  (nu) N m, of the model's joints

    With friction its state is z and the lengths of the tendons, which are updated with every step of the plant, and
    every 5 ms if it has none. Non-finite states of the plant leave it unchanged.
    """

    def __init__(self, finger: PlantFinger, command: str):
        """`command` is "tension" or "pull"."""
        tendons = Tendons(finger.finger)
        super().__init__(finger, (finger.plant.time_step() or _FRICTION_PERIOD) if tendons.slide else None)
        self._tendons, self._is_pulled = tendons, command == PULL
        count = self._count = len(self._finger.tendons)
        command_port = f"{command}_command"
        self.take(command_port, count)
        self.put_out(TENSION, self.tension, "state", command_port, unit="N", **self._finger.tendon_axis)
        if tendons.slide:
            self.remember(
                *("friction", same),
                begin=np.zeros(2 * count),
                begin_of=(self.initial_friction, "state"),
                keep=self.next_friction,
                kept=("state",),
                at_first=True,
            )
        friction = ["friction"] if tendons.slide else []
        actuators = finger.actuator_names
        self.put_out("actuation", self.actuation, "state", command_port, *friction, unit="N m", actuator=actuators)

    def tension(self, state: Array, command: Array) -> Array:
        """Tension at the pulled ends, (..., T) N, in plant states, (..., nq + nv), from commands, (..., T)."""
        if self._is_pulled:
            return self._tendons.tensions(self._joints(state), command)
        return np.maximum(command, 0.0)

    def actuation(self, state: Array, command: Array, friction: Array | None = None) -> Array:
        """Torques on the joints, (..., nu) N m; `friction` is the state of the friction, (..., 2 T), if any."""
        sliding = None if friction is None else friction[..., : self._count]
        return self._actuation(self._tendons.torques(self._joints(state), self.tension(state, command), sliding))

    def initial_friction(self, state: Array) -> Array:
        """The state of the friction where a run begins, (..., 2 T)."""
        lengths = path_lengths(self._tendons.paths, self._joints(state))
        return np.concatenate([np.zeros_like(lengths), lengths], axis=-1)

    def next_friction(self, memory: Array, state: Array) -> Array:
        """The state of the friction, (..., 2 T), when the tendons have moved as the plant has."""
        lengths = path_lengths(self._tendons.paths, self._joints(state))
        sliding, last_lengths = np.split(memory, 2, axis=-1)
        next_memory = np.concatenate([self._tendons.next_sliding(sliding, last_lengths - lengths), lengths], axis=-1)
        return np.where(np.isfinite(next_memory), next_memory, memory)


class BentChambers(_PathDriveBlock):
    """Change of the torque of chambers as the finger that they run through bends and twists.

    ::

        state (nq + nv) of the plant ---> +--------------+
        pressure (C) Pa ----------------> | BentChambers | ---> actuation  (nu) N m, of the model's joints
                                          +--------------+
    """

    def __init__(self, finger: PlantFinger):
        super().__init__(finger)
        self.take("pressure", self._finger.pressures)
        actuators = finger.actuator_names
        self.put_out("actuation", self._torque, "state", "pressure", unit="N m", actuator=actuators)

    def _torque(self, state: Array, pressure: Array) -> Array:
        """Torques on the joints, (..., nu) N m, in states of the plant, (..., nq + nv), from pressures, (..., C) Pa."""
        finger, straight = self._finger, self._finger.pressure_gains
        effective = finger.effective_pressure(pressure)[..., None, :]
        gains = finger.chamber_gains(self._joints(state))
        return self._actuation({name: (effective @ (gain - straight[name]))[..., 0, :] for name, gain in gains.items()})
