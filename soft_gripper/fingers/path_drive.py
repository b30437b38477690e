"""What drives a finger along paths that turn with it: tendons, and chambers of a finger that twists.

Their torque depends on the shape, so it is computed at every step of the plant, from the gradients of the lengths of
the paths (`paths`); the chamber law of the straight finger is one matrix, see `pressure_drive`. Drake's own tendon
constraint has fixed limits and constant gradients, so that no run could pull it, nor a twist slant it.

A tendon that is commanded in length is a spring between its winch and its end, slack where it would have to push,

    T = max(0, stiffness (pulled length - (l(0) - l(q)))) .

A tendon that slides over its sheath loses tension where the finger is bent (capstan): beyond the angle phi of the
bend it pulls with  T exp(-mu phi z) . z is 1 where the tendon is being pulled, -1 where it is let go, and changes over
a short travel of the tendon, so that a joint that stands still keeps its friction (Dahl, *A Solid Friction Model*,
1968).
"""

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.paths import length_gradients, path_lengths
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.signals import describe

TENSION, PULL = "tension", "pull"


def tendon_tensions(finger: Finger, q: Mapping[str, Array], pulled: Array) -> Array:
    """Tensions of tendons of which a length is pulled out, (..., T) m -> (..., T) N, at joint positions q.

    `q` has the positions of the joints, (..., N) rad, or m, by the way in which they yield.
    """
    paths, straight = finger.tendon_paths, {way: np.zeros(finger.segments) for way in q}
    shortened = path_lengths(paths, straight, finger.segment_length) - path_lengths(paths, q, finger.segment_length)
    return np.maximum(0.0, np.array([tendon.stiffness for tendon in finger.tendons]) * (pulled - shortened))


def tendon_torques(
    finger: Finger, q: Mapping[str, Array], tensions: Array, sliding: Array | None = None
) -> dict[str, Array]:
    """Torques of tendons at the joints, (..., N) N m, and N where they slide, by the way in which these yield.

    Args:
        finger: has T tendons.
        q: positions of its joints, (..., N) rad, or m.
        tensions: at the pulled ends, (..., T) N.
        sliding: z of the friction, (..., T), from -1 to 1; None: no friction.
    """
    gradients = length_gradients(finger.tendon_paths, q, finger.segment_length)
    along = tensions[..., None]
    if sliding is not None:
        along = along * _capstan(finger, q, sliding)
    return {way: -(along * gradient).sum(axis=-2) for way, gradient in gradients.items()}


def _capstan(finger: Finger, q: Mapping[str, Array], sliding: Array) -> Array:
    """Tension in the middle of every segment over that at the pulled end, (..., T, N)."""
    bend = np.hypot(q["bending"], q.get("sideways", 0.0))[..., None, :]
    passed = bend * finger.tendon_paths.covered / finger.segment_length
    friction = np.array([tendon.friction for tendon in finger.tendons])
    angle = np.cumsum(passed, axis=-1) - passed / 2
    return np.asarray(np.exp(-(friction * sliding)[..., None] * angle))


def turned_friction(finger: Finger, sliding: Array, travel: Array) -> Array:
    """z of the friction after tendons travelled by (..., T) m toward their pulled ends, (..., T)."""
    reversal = np.array([tendon.reversal for tendon in finger.tendons])
    toward, kept = np.sign(travel), np.exp(-np.abs(travel) / reversal)
    return np.asarray(toward + (sliding - toward) * kept)


class _OnPaths(LeafSystem):
    """Reads the joints of a finger from the state of its plant, and drives its actuators."""

    def __init__(self, finger: PlantFinger):
        super().__init__()
        ways = finger.finger.yields
        self._ways = {way: np.argmax(finger.position_selector(way), axis=-1) for way in ways}
        self._actuators = {way: np.argmax(finger.actuator_selector(way), axis=-1) for way in ways}
        self._finger, self._size = finger.finger, len(finger.actuator_names)
        self.DeclareVectorInputPort("state", finger.plant.num_multibody_states())

    def _joints(self, context: Context) -> dict[str, Array]:
        state = self.get_input_port(0).Eval(context)
        return {way: state[places] for way, places in self._ways.items()}

    def _actuation(self, torques: Mapping[str, Array]) -> Array:
        actuation = np.zeros(self._size)
        for way, torque in torques.items():
            actuation[self._actuators[way]] = torque
        return actuation


class TendonDrive(_OnPaths):
    """Turns tensions, or pulled lengths, of the tendons of a finger into torques on its joints.

    ::

        state (nq + nv) of the plant --------> +-------------+ ---> tension    (T) N, at the pulled ends
        tension (T) N, or pull (T) m, -------> | TendonDrive |
        as commanded                           +-------------+ ---> actuation  (nu) N m, of the model's joints

    With friction its state is z and the lengths of the tendons, which are updated with every step of the plant.
    """

    def __init__(self, finger: PlantFinger, command: str):
        """`command` is "tension" or "pull"."""
        super().__init__(finger)
        count, self._is_pulled = len(self._finger.tendons), command == PULL
        self._commanded = self.DeclareVectorInputPort(f"{command}_command", count)
        self._slides = any(tendon.friction > 0 for tendon in self._finger.tendons)
        tension = self.DeclareVectorOutputPort(TENSION, count, self._put_tension)
        self.DeclareVectorOutputPort("actuation", self._size, self._put_actuation)
        if self._slides:
            self.DeclareDiscreteState(2 * count)
            self.DeclareInitializationDiscreteUpdateEvent(self._begin)
            self.DeclarePeriodicDiscreteUpdateEvent(finger.plant.time_step(), 0.0, self._travel)
        describe(tension, "N", **self._finger.tendon_axis)

    def _tension(self, context: Context, q: Mapping[str, Array]) -> Array:
        commanded = self._commanded.Eval(context)
        return tendon_tensions(self._finger, q, commanded) if self._is_pulled else np.maximum(commanded, 0.0)

    def _put_tension(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._tension(context, self._joints(context)))

    def _put_actuation(self, context: Context, output: BasicVector) -> None:
        q = self._joints(context)
        sliding = context.get_discrete_state_vector().value()[: len(self._finger.tendons)] if self._slides else None
        output.SetFromVector(self._actuation(tendon_torques(self._finger, q, self._tension(context, q), sliding)))

    def _lengths(self, context: Context) -> Array:
        finger = self._finger
        return path_lengths(finger.tendon_paths, self._joints(context), finger.segment_length)

    def _begin(self, context: Context, state: DiscreteValues) -> None:
        state.set_value(np.concatenate([np.zeros(len(self._finger.tendons)), self._lengths(context)]))

    def _travel(self, context: Context, state: DiscreteValues) -> None:
        sliding, before = np.split(context.get_discrete_state_vector().value(), 2)
        now = self._lengths(context)
        state.set_value(np.concatenate([turned_friction(self._finger, sliding, before - now), now]))


class BentChambers(_OnPaths):
    """What the torque of chambers changes as the finger that they run through bends and twists.

    ::

        state (nq + nv) of the plant ---> +--------------+
        pressure (C) Pa ----------------> | BentChambers | ---> actuation  (nu) N m, of the model's joints
                                          +--------------+
    """

    def __init__(self, finger: PlantFinger):
        super().__init__(finger)
        self._pressure = self.DeclareVectorInputPort("pressure", self._finger.pressures)
        self.DeclareVectorOutputPort("actuation", self._size, self._put_actuation)

    def _put_actuation(self, context: Context, output: BasicVector) -> None:
        finger, straight = self._finger, self._finger.pressure_gains
        pressure = finger.effective_pressure(self._pressure.Eval(context))
        gains = finger.chamber_gains(self._joints(context))
        output.SetFromVector(self._actuation({way: pressure @ (gain - straight[way]) for way, gain in gains.items()}))
