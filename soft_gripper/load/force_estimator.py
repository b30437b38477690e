"""ForceEstimator: shape and driving torque -> external torque at every joint, at rest and in motion."""

from operator import attrgetter

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.fingers.finger import Finger
from soft_gripper.load.torque_balance import DELAY, SAMPLES, ExternalTorque, Motion, TorqueBalance, windows


class ForceEstimator(ArrayBlock):
    """Estimates what bends one finger besides its driving torque, its weight and its motion (paper, II.D).

    ::

        estimated_joint_angles (N) rad ---> +----------------+ ---> free_bending_angles  (N) rad, driven and no more
        driving_torque (N) N m -----------> | ForceEstimator | ---> external_torque      (N) N m, positive closes
        X_WB (12) [R | p] ----------------> +----------------+ ---> torque_tolerance     (N) N m

    Torque at the joints, not contact force, from the dynamic balance of `torque_balance`: it belongs to two
    samples ago, and `torque_tolerance` says what inertia and steps of the pressure may leave in it without contact.
    NaN until there are five samples, and as long as one of the last five is not finite. Without gravity the
    weight of the finger stays in the result.

    Give it inputs that are sampled together every `period` s, from time 0, in discrete state.
    """

    def __init__(self, finger: Finger, gravity: Array, period: float, noisy: bool = False):
        """
        Args:
            finger: as it is believed to be.
            gravity: in the world, (3,) m/s^2, or zero for no compensation.
            period: of the samples, s.
            noisy: the joint angles are too noisy to be differentiated twice; the finger is taken to move as its
                driving torque alone moves it, besides the motion of its base.
        """
        super().__init__()
        self._finger, self._balance = finger, TorqueBalance(finger)
        self._gravity, self._period, self._noisy = gravity, period, noisy
        joints = finger.segments
        sizes = {ANGLES: joints, DRIVING_TORQUE: joints, "X_WB": 12}
        self._inputs = [self.take(name, size) for name, size in sizes.items()]
        self.DeclareDiscreteState(np.full((SAMPLES - 1) * sum(sizes.values()), np.nan))  # the samples before
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        self.remember("samples", self._read_samples, *sizes, over_time=_recorded_samples, period=period)
        self.derive("external", self._external_torque, "samples")
        self.put_out("free_bending_angles", finger.angle, DRIVING_TORQUE, unit="rad", joint=range(joints))
        for name, part in (("external_torque", "torque"), ("torque_tolerance", "tolerance")):
            self.put_out(name, attrgetter(part), "external", unit="N m", joint=range(joints))

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Keeps the sample that was taken a period ago; at time 0 there is none.

        An event that began at `period` instead would drift off those at multiples of it by rounding.
        """
        if context.get_time() > 0:
            values.set_value(self.read("samples", context)[1:].ravel())

    def _read_samples(self, context: Context) -> Array:
        """The samples remembered and the present one, (5, 2 N + 12): joint angles, driving torque, X_WB."""
        present = [port.Eval(context) for port in self._inputs]
        samples = np.concatenate([context.get_discrete_state_vector().value(), *present])
        return samples.reshape(SAMPLES, -1)

    def _external_torque(self, samples: Array) -> ExternalTorque:
        """From samples (..., 5, 2 N + 12)."""
        joints = self._finger.segments
        q, driving = samples[..., :joints], samples[..., joints : 2 * joints]
        X_WB = samples[..., 2 * joints :].reshape(*samples.shape[:-1], 3, 4)
        motion = Motion(q, driving, X_WB)
        return self._balance.external_torque(motion, self._gravity, self._period, self._moving(motion))

    def _moving(self, motion: Motion) -> Array | None:
        """The present shape, moved as the driving torque moves a free finger."""
        if not self._noisy:
            return None
        free = self._finger.angle(motion.driving)
        return motion.q[..., DELAY, None, :] + free - free[..., DELAY, None, :]


def _recorded_samples(time: Array, *inputs: Array) -> Array:
    """What `_read_samples` reads at every sample of a recording, (T, 5, 2 N + 12): at time 0 nothing is kept."""
    present = np.concatenate(inputs, axis=-1)
    kept = np.where(time[:, None] > 0, present, np.nan)
    before = np.concatenate([np.full((SAMPLES - 1, present.shape[-1]), np.nan), kept])
    samples = windows(before).copy()
    samples[:, -1] = present
    return samples
