"""ContactDetector: which finger touches something, and since when."""

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem, ValueProducer

from soft_gripper.arrays import Array
from soft_gripper.contact_residual import SAMPLES, BaseSection, Motion, contact_residual
from soft_gripper.sensor_layout import SensorLayout

THRESHOLD = 2.5e-3  # N m
_RELEASE = 0.5  # of the threshold, where contact ends


class Touch(NamedTuple):
    """What one sample says."""

    samples: Array  # (5, S + 13), the last of them, row after row
    residual: float  # N m
    contact: float  # 0 or 1
    since: float  # s, NaN before any


class ContactDetector(LeafSystem):
    """Tells from the estimates of one finger alone whether it touches anything, also while an arm moves it.

    theta (S) rad ------> +-----------------+ ---> contact           (1) 0 or 1
    pressure (1) Pa ----> | ContactDetector | ---> contact_residual  (1) N m, torque that only contact explains
    X_WB ---------------> +-----------------+ ---> contact_time      (1) s, of the last beginning of a contact, or NaN

    The residual (see `contact_residual`) is the mean torque on the joints of the section at the base, negative
    where contact holds the finger open. Contact begins when the residual is beyond the threshold for sure, and
    ends when it is within half of it for sure: the tolerance, by which inertia and steps of the pressure may
    be misjudged, counts against every change.

    Give it inputs that are sampled together every `period` s, from time 0, in discrete state as BasePoseSensor does (an
    abstract ZeroOrderHold would be a sample ahead when samples are remembered). The outputs follow them at once, and
    tell of two samples before. The residual is not finite until there are five samples, and as long as one of the
    last five is not; contact then holds its value.

    The threshold is for samples every 10 ms and for fingers like the shipped ones, with two sections or more: 2.5 mN m.
    Carried about with 17 m/s^2 and 4 rad/s the residual exceeds the tolerance by at most 0.9 mN m (with two sections
    2.0) in a plant with steps of 10 ms, by 0.3 (0.8) with steps of 5 ms; whatever the step of the pressure from -60 to
    240 kPa, by 0.4. Noise of 1e-4 (rms) in the strain adds 0.24 mN m (rms); twice that can be borne. After the
    first contact with a box of 20 to 60 g, contact begins within 30 ms if the pressure rises by 200 kPa/s or more,
    within 40 ms (60) at 100 kPa/s and within 80 ms (90) at 50 kPa/s. Its end is told within 0.1 s at rest and within
    0.3 s at full speed. A single section would have to have 6 mN m.
    """

    def __init__(self, layout: SensorLayout, gravity: Array, period: float, threshold: float = THRESHOLD):
        """A finger of the given sensors; `gravity` in the world, (3,) m/s^2; `threshold` in N m."""
        super().__init__()
        self._layout, self._section = layout, BaseSection(layout)
        self._gravity, self._period, self._threshold = gravity, period, threshold
        self._theta = self.DeclareVectorInputPort("theta", layout.sections)
        self._pressure = self.DeclareVectorInputPort("pressure", 1)
        self._X_WB = self.DeclareAbstractInputPort("X_WB", AbstractValue.Make(RigidTransform()))
        self.DeclareDiscreteState(np.full((SAMPLES - 1) * (layout.sections + 13), np.nan))  # the samples before
        self.DeclareDiscreteState([0.0, np.nan, 0.0])  # contact, since, time of the present sample
        self._touch = self.DeclareCacheEntry(
            "touch",
            ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc_touch),
            {self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        self._declare("contact", "contact")
        self._declare("contact_residual", "residual")
        self._declare("contact_time", "since")

    def _declare(self, name: str, field: str) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.SetAtIndex(0, getattr(self._touch.Eval(context), field))

        self.DeclareVectorOutputPort(name, 1, calc, {self.cache_entry_ticket(self._touch.cache_index())})

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Keeps the sample that was taken a period ago; at time 0 there is none.

        An event that began at `period` instead would drift off those at multiples of it by rounding.
        """
        if context.get_time() == 0:
            return
        touch = self._touch.Eval(context)
        values.set_value(0, touch.samples[1:].ravel())
        values.set_value(1, [touch.contact, touch.since, context.get_time()])

    def _calc_touch(self, context: Context, value: AbstractValue) -> None:
        samples = self._read_samples(context)
        contact, since, now = context.get_discrete_state(1).value()
        torque, tolerance = contact_residual(self._section, self._motion(samples), self._gravity, self._period)
        if not contact and abs(torque) - tolerance > self._threshold:
            contact, since = 1.0, now
        elif abs(torque) + tolerance < _RELEASE * self._threshold:
            contact = 0.0
        value.set_value(Touch(samples, float(torque), contact, since))

    def _read_samples(self, context: Context) -> Array:
        """The samples remembered and the present one, (5, S + 13): theta, pressure, X_WB as [R | p]."""
        X_WB = self._X_WB.Eval(context).GetAsMatrix34().ravel()
        present = self._theta.Eval(context), self._pressure.Eval(context), X_WB
        return np.concatenate([context.get_discrete_state(0).value(), *present]).reshape(SAMPLES, -1)

    def _motion(self, samples: Array) -> Motion:
        sections = self._layout.sections
        X_WB = samples[:, sections + 1 :].reshape(SAMPLES, 3, 4)
        return Motion(samples[:, :sections], samples[:, sections], X_WB)
