"""ContactDetector: detects whether, and since when, a finger touches something.

Contact is detected from the section at the base, where the lever is longest.
"""

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from soft_gripper.cached import Cached, weakly
from soft_gripper.signals import describe

THRESHOLD = 2.5e-3  # N m
_RELEASE = 0.5  # of the threshold, below which contact ends


class Touch(NamedTuple):
    """Result of one sample."""

    residual: float  # N m
    contact: float  # 0 or 1
    since: float  # s, NaN before the first contact


class ContactDetector(LeafSystem):
    """Detects from the external torque of one finger whether it touches anything, also while an arm moves it.

    ::

        external_torque (N) N m ----> +-----------------+ ---> contact           (1) 0 or 1
                                      | ContactDetector | ---> contact_residual  (1) N m, mean over the first joints
        torque_tolerance (N) N m ---> +-----------------+ ---> contact_time      (1) s, last beginning of a contact

    The residual is the mean torque on the joints of the section at the base, where the lever of a contact is longest,
    negative where contact holds the finger open. Contact begins when the residual exceeds the threshold by more
    than the tolerance, and ends when residual and tolerance together are within half of it: the tolerance, by which
    inertia and steps of the pressure may be misjudged, counts against every change. `contact_time` is NaN before any.

    Give it the outputs of a ForceEstimator that is sampled every `period` s. While its torque is not finite, contact
    holds its value. The threshold is for samples every 10 ms and for fingers like the shipped ones, with two sections
    or more; docs/manipulation.md has what was measured with it.
    """

    def __init__(self, joints: int, base_joints: int, period: float, threshold: float = THRESHOLD):
        """`joints` of the finger, of which `base_joints` lie in the section at the base; `threshold` in N m."""
        super().__init__()
        self._base_joints, self._threshold = base_joints, threshold
        self._torque = self.DeclareVectorInputPort("external_torque", joints)
        self._tolerance = self.DeclareVectorInputPort("torque_tolerance", joints)
        self.DeclareDiscreteState([0.0, np.nan, 0.0])  # contact, since, time of the current sample
        followed = {self.all_input_ports_ticket(), self.xd_ticket()}
        self._touch = Cached(self, "touch", weakly(self._calc_touch), followed)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        self._declare("contact", "contact", "1")
        self._declare("contact_residual", "residual", "N m")
        self._declare("contact_time", "since", "s")

    def _declare(self, name: str, field: str, unit: str) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.SetAtIndex(0, getattr(self._touch.Eval(context), field))

        describe(self.DeclareVectorOutputPort(name, 1, calc, {self._touch.ticket}), unit)

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Stores the result of the previous sample; at time 0 there is none."""
        if context.get_time() > 0:
            touch = self._touch.Eval(context)
            values.set_value([touch.contact, touch.since, context.get_time()])

    def _calc_touch(self, context: Context, value: AbstractValue) -> None:
        contact, since, now = context.get_discrete_state_vector().value()
        torque, tolerance = (
            float(port.Eval(context)[: self._base_joints].sum()) / self._base_joints
            for port in (self._torque, self._tolerance)
        )
        if not contact and abs(torque) - tolerance > self._threshold:
            contact, since = 1.0, now
        elif abs(torque) + tolerance < _RELEASE * self._threshold:
            contact = 0.0
        value.set_value(Touch(torque, contact, since))
