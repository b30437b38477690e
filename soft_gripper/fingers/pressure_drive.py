"""PressureDrive: pressures -> torques on the joints, made of Drake's C++ primitives.

Pressure acts through actuators, which the expanded URDF declares: cenic integrates actuation twice as fast as applied
generalized forces.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import (
    Demultiplexer,
    FirstOrderLowPassFilter,
    LinearSystem,
    MatrixGain,
    Multiplexer,
    Saturation,
)

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.fingers.finger_parts import PressureLaw
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock
from soft_gripper.run_begin import RunBegin
from soft_gripper.signals import describe
from soft_gripper.steps import TIME


class Leak(ArrayBlock):
    """Pressure behind a leak.

    ::

        pressure (C) Pa ---> +------+
        offset (1) s ------> | Leak | ---> pressure_left  (C) Pa
                             +------+

    `offset` is that of a RunBegin.
    """

    def __init__(self, shares: Array, time: float):
        """Fractions `shares`, (C), of the pressure leak from `time` s after the beginning of a run."""
        super().__init__()
        self._remaining_fractions, self._time = 1 - shares, time
        self.take("pressure", len(shares))
        self.take("offset", 1)
        chambers = range(len(shares))
        self.put_out("pressure_left", self._pressure_left, "pressure", TIME, "offset", unit="Pa", chamber=chambers)

    def _pressure_left(self, pressure: Array, time: Array, offset: Array) -> Array:
        """Pressures behind the leak, (..., C) Pa, at times and offsets, (..., 1) s."""
        return np.where(time + offset >= self._time, pressure * self._remaining_fractions, pressure)


class PressureDrive(Diagram):
    """Turns commanded pressures, limited and delayed, into torques on the joints of a model.

    ::

                                       +---------------+ ---> {finger}.pressure  (C) Pa, in the chambers
        {finger}.pressure_command ---> | PressureDrive |
                                       +---------------+ ---> actuation          (nu) N m, of the model's joints

    There is a command, (C) Pa, for every finger with C chambers; one source wired to fingers with one is a common
    pressure. Inside: Saturation -> first-order lag and Leak (if there are any) -> laws of the pressure (if there are
    any) -> MatrixGain (the chamber law, tau_i = p A(s_i) e(s_i); a joint that stretches is pushed by p A(s_i)).
    """

    def __init__(
        self,
        torque_maps: Mapping[str, Array],
        minimum: float,
        maximum: float,
        time_constant: float = 0.0,
        time_step: float = 0.0,
        laws: Mapping[str, Sequence[PressureLaw | None]] | None = None,
        leaks: Mapping[str, float] | None = None,
        leak_time: float = 0.0,
    ):
        """
        Args:
            torque_maps: for every finger the actuation of the model by one effective pascal, (nu, C) N m/Pa; see
                `pressure_torque_map`.
            minimum, maximum: limits of the pressures, Pa.
            time_constant: of the first-order lag between command and chamber, s; 0 for none.
            time_step: of a discrete plant, s; the lag then uses the same steps. 0 for a continuous one.
            laws: pressure laws of the chambers of each finger; None: the effective pressure is that in the chamber.
            leaks: fractions of pressure that fingers lose behind the sensor, from `leak_time` s on; None: no leaks.
        """
        super().__init__()
        builder = DiagramBuilder()
        columns = [np.reshape(torque_map, (len(torque_map), -1)) for torque_map in torque_maps.values()]
        sizes = [column.shape[1] for column in columns]
        command_count, ones = sum(sizes), np.ones(sum(sizes))
        commands = builder.AddNamedSystem("commands", Multiplexer(sizes))
        chain = [builder.AddNamedSystem("limits", Saturation(minimum * ones, maximum * ones))]
        if time_constant > 0:
            chain.append(builder.AddNamedSystem("lag", lag(time_constant, time_step, command_count)))
        pressures = builder.AddNamedSystem("pressures", Demultiplexer(sizes))
        builder.Connect(chain[-1].get_output_port(), pressures.get_input_port())
        if leaks:
            lost = np.repeat([leaks.get(name, 0.0) for name in torque_maps], sizes)
            chain.append(builder.AddNamedSystem("leak", Leak(lost, leak_time)))
            begin = builder.AddNamedSystem("begin", RunBegin())
            builder.Connect(begin.get_output_port(), chain[-1].GetInputPort("offset"))
        chamber_laws = [law for name in torque_maps for law in (laws or {}).get(name, ())]
        if any(chamber_laws):  # as one block; each is linear between the points of all
            points = np.unique(np.concatenate([law.pressure for law in chamber_laws if law is not None]))
            effective = np.array([points if law is None else law.curve(points) for law in chamber_laws])
            curves = PiecewiseLinear(np.broadcast_to(points, effective.shape), effective)
            chain.append(builder.AddNamedSystem("laws", PiecewiseLinearBlock(curves)))
        chambers = builder.AddNamedSystem("chambers", MatrixGain(np.hstack(columns)))
        for upstream, downstream in zip([commands, *chain], [*chain, chambers], strict=True):
            builder.Connect(upstream.get_output_port(), downstream.get_input_port(0))
        for i, finger in enumerate(torque_maps):
            builder.ExportInput(commands.get_input_port(i), f"{finger}.pressure_command")
            builder.ExportOutput(pressures.get_output_port(i), f"{finger}.pressure")
        builder.ExportOutput(chambers.get_output_port(), "actuation")
        builder.BuildInto(self)
        for finger, size in zip(torque_maps, sizes, strict=True):
            chambers = {"chamber": range(size)} if size > 1 else {}
            describe(self.GetOutputPort(f"{finger}.pressure"), "Pa", **chambers)


def lag(time_constant: float, time_step: float, count: int) -> System:
    """First-order lag of `count` commands; in discrete steps it is exact for commands that jump between them."""
    if time_step == 0:
        return FirstOrderLowPassFilter(time_constant, count)
    decay, identity = np.exp(-time_step / time_constant), np.eye(count)
    return LinearSystem(A=decay * identity, B=(1 - decay) * identity, C=identity, D=0 * identity, time_period=time_step)


def pressure_torque_map(finger: PlantFinger) -> Array:
    """Actuation of the finger's model by one effective pascal in each chamber, (nu, C) N m/Pa; N/Pa where it stretches.

    It is that of the straight finger; changes by twist are not in it.
    """
    gains, names = finger.finger.pressure_gains, finger.finger.driven_deformations
    return np.asarray(sum(finger.actuator_selector(name).T @ gains[name].T for name in names))
