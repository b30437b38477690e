"""Grip control: set-point steps, mean torque and force of a grip or its bound, and selection of the lower command."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import CLOSING
from soft_gripper.estimators.force_posterior import INTERVAL
from soft_gripper.run_begin import declare_run_time
from soft_gripper.signals import describe


class LowSelector(ArrayBlock):
    """Override control: outputs the smaller of two inputs.

    ::

        first (1) ----> +-------------+
                        | LowSelector | ---> selected  (1)
        second (1) ---> +-------------+
    """

    def __init__(self) -> None:
        super().__init__()
        for name in ("first", "second"):
            self.take(name, 1)
        self.put_out("selected", lambda first, second: np.where(second < first, second, first), "first", "second")


class GripTorque(ArrayBlock):
    """The mean opening torque at the base joints of a gripper's fingers; lateral accelerations of the palm cancel.

    ::

        {finger}.external_torque (N) N m ---> GripTorque ---> torque  (1) N m
    """

    def __init__(self, joints: Mapping[str, int]):
        """`joints` are the numbers of joints of the fingers, by their names."""
        super().__init__()
        ports = [f"{name}.external_torque" for name in joints]
        for port, n in zip(ports, joints.values(), strict=True):
            self.take(port, n)
        # The torques of the first joints are positive where they close a finger.
        self.put_out("torque", lambda *torques: -_sum([t[..., 0] for t in torques]) / len(torques), *ports, unit="N m")


class GripForce(ArrayBlock):
    """The mean estimated closing force of the fingers of a gripper: the component along -x of their bases.

    ::

        {finger}.contact_force_vector (3) N ---> GripForce ---> force  (1) N

    Friction along a finger hardly changes it, and on two opposed fingers that hold an object it is equal. An unknown
    force, NaN, makes the mean NaN.
    """

    def __init__(self, fingers: Iterable[str]):
        super().__init__()
        ports = [f"{name}.contact_force_vector" for name in fingers]
        for port in ports:
            self.take(port, 3)
        self.put_out("force", lambda *forces: _sum(forces) @ CLOSING / len(forces), *ports, unit="N")


def _sum(values: Sequence[Array]) -> Array:
    return sum(values[1:], values[0])


class GripForceBound(LeafSystem):
    """The mean upper bound of the contact force of the fingers of a gripper.

    ::

        {finger}.contact_force_interval (3) N ---> +----------------+
                                                   | GripForceBound | ---> force  (1) N
        {finger}.contact (1) 0 or 1 -------------> +----------------+

    The bound of a finger is the upper end of its interval, which the force exceeds with a probability of at most 2.5 %.
    A finger without a detected contact counts as 0: the posterior takes the inertia of a free finger on an accelerated
    arm for a contact, the detector does not. An unknown bound, NaN, makes the mean NaN. The interval of such a finger
    is not read, because the posterior costs half a run; so this is no ArrayBlock, which reads all that it takes.
    """

    def __init__(self, fingers: Iterable[str]):
        super().__init__()
        self._ports = []
        for name in fingers:
            interval = self.DeclareVectorInputPort(f"{name}.contact_force_interval", len(INTERVAL))
            self._ports.append((interval, self.DeclareVectorInputPort(f"{name}.contact", 1)))
        port = self.DeclareVectorOutputPort("force", 1, self._calc_force, {self.all_input_ports_ticket()})
        describe(port, "N")

    def _calc_force(self, context: Context, output: BasicVector) -> None:
        bounds = [float(force.Eval(context)[-1]) if touch.Eval(context)[0] else 0.0 for force, touch in self._ports]
        output.SetAtIndex(0, sum(bounds) / len(bounds))


class SampledSteps(LeafSystem):
    """A source that changes only at samples, so that downstream Python blocks are not called more often.

    ::

        +--------------+
        | SampledSteps | ---> value  (1)
        +--------------+
    """

    def __init__(self, values: Sequence[float], duration: float, period: float):
        """Holds each value for `duration` s from the beginning of a run, the last forever; samples every `period` s."""
        super().__init__()
        self._values, self._duration, self._run_time = tuple(values), duration, declare_run_time(self)
        self._value = self.DeclareDiscreteState([values[0]])
        self.DeclareStateOutputPort("value", self._value)
        if len(values) > 1:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, values: DiscreteValues) -> None:
        step = int((self._run_time(context) + 1e-9) / self._duration)
        values.set_value(self._value, [self._values[min(step, len(self._values) - 1)]])
