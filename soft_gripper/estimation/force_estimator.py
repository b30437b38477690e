"""ForceEstimator: shape and driving torque -> external torque at every joint, at rest and in motion."""

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem, ValueProducer

from soft_gripper.arrays import Array
from soft_gripper.estimation.torque_balance import DELAY, SAMPLES, ExternalTorque, Motion, TorqueBalance
from soft_gripper.fingers.finger import Finger
from soft_gripper.shape.driving_torque import DRIVING_TORQUE
from soft_gripper.shape.finger_shape import ANGLES
from soft_gripper.signals import describe


class Estimate(NamedTuple):
    """What one sample leads to."""

    samples: Array  # (5, 2 N + 12), the last of them, row after row
    external: ExternalTorque


class ForceEstimator(LeafSystem):
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
        self._angles = self.DeclareVectorInputPort(ANGLES, joints)
        self._driving = self.DeclareVectorInputPort(DRIVING_TORQUE, joints)
        self._X_WB = self.DeclareVectorInputPort("X_WB", 12)
        self.DeclareDiscreteState(np.full((SAMPLES - 1) * (2 * joints + 12), np.nan))  # the samples before
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc)
        inputs = {self.all_input_ports_ticket(), self.xd_ticket()}
        self._estimate = self.DeclareCacheEntry("external torque", producer, inputs)
        external = {self.cache_entry_ticket(self._estimate.cache_index())}
        free = self.DeclareVectorOutputPort("free_bending_angles", joints, self._calc_free, {self._driving.ticket()})
        describe(free, "rad", joint=range(joints))
        for name, calc in (("external_torque", self._calc_torque), ("torque_tolerance", self._calc_tolerance)):
            describe(self.DeclareVectorOutputPort(name, joints, calc, external), "N m", joint=range(joints))

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Keeps the sample that was taken a period ago; at time 0 there is none.

        An event that began at `period` instead would drift off those at multiples of it by rounding.
        """
        if context.get_time() > 0:
            values.set_value(self._estimate.Eval(context).samples[1:].ravel())

    def _read_samples(self, context: Context) -> Array:
        """The samples remembered and the present one, (5, 2 N + 12): joint angles, driving torque, X_WB."""
        present = (port.Eval(context) for port in (self._angles, self._driving, self._X_WB))
        samples = np.concatenate([context.get_discrete_state_vector().value(), *present])
        return samples.reshape(SAMPLES, -1)

    def _calc(self, context: Context, value: AbstractValue) -> None:
        samples, joints = self._read_samples(context), self._finger.segments
        q, driving, X_WB = np.split(samples, [joints, 2 * joints], axis=-1)
        motion = Motion(q, driving, X_WB.reshape(SAMPLES, 3, 4))
        external = self._balance.external_torque(motion, self._gravity, self._period, self._moving(motion))
        value.set_value(Estimate(samples, external))

    def _moving(self, motion: Motion) -> Array | None:
        """The present shape, moved as the driving torque moves a free finger."""
        if not self._noisy:
            return None
        free = self._finger.angle(motion.driving)
        return motion.q[DELAY] + free - free[DELAY]

    def _calc_free(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._finger.angle(self._driving.Eval(context)))

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._estimate.Eval(context).external.torque)

    def _calc_tolerance(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._estimate.Eval(context).external.tolerance)
