"""SensorBlock: samples the joints of a finger and reads its sensors. Hold: samples any vector."""

from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import measures_strain


def joints_port(deformation: str) -> str:
    """Name of the port with the joint positions of a deformation."""
    if deformation == "bending":
        return "joint_angles"
    return f"{deformation}_lengths" if deformation in SLIDES else f"{deformation}_angles"


class SensorBlock(ArrayBlock):
    """Samples the joints of one finger and outputs the readings of sensors of any kind.

    ::

        joint_angles (N) rad ---> | SensorBlock | ---> curvature (R) readings, or what else the sensors measure

    Of a finger that leaves its plane, sensors that see it do so also take `sideways_angles` and `twist_angles` (N) rad
    and `stretch_lengths` (N) m, as far as it yields so. The outputs hold their values between samples.
    """

    def __init__(self, layout: MeasurementModel, period: float):
        """Samples the sensors every `period` s, beginning at initialization."""
        super().__init__(period)
        ports = [joints_port(deformation) for deformation in layout.deformations]
        for port in ports:
            self.take(port, layout.finger.segments)
            self.sample(f"sampled_{port}", port)
        sampled = [f"sampled_{port}" for port in ports]
        planar = len(sampled) == 1
        signals = layout.signals if planar else lambda *angles: layout.signals(np.concatenate(angles, axis=-1))
        self.derive("signals", signals, *sampled)
        for name in layout.signals(layout.straight):
            self.put_out(name, itemgetter(name), "signals", unit=layout.unit, **layout.axes)


class Hold(ArrayBlock):
    """Samples a vector and outputs it, some samples later.

    ::

        u (n) ---> Hold ---> y (n), 0 before the first sample
    """

    def __init__(
        self, period: float, size: int, delay: int = 0, unit: str | Sequence[str] = "1", **axes: Sequence[Any]
    ):
        """Samples every `period` s; delays by `delay` samples; unit and axes as for `describe`."""
        super().__init__(period)
        self.take("u", size)
        self.sample("sampled", "u", at_initialization=False)
        begin = np.zeros((delay, size))

        def append(line: Array, newest: Array) -> Array:
            return np.concatenate([line, newest[..., None, :]], axis=-2)

        def lines(newest: Array) -> Array:
            """Lines along a recording, (T, size) -> (T, delay + 1, size)."""
            started = np.concatenate([np.zeros_like(newest[:1]), newest[1:]])  # at the first sample nothing is
            padded = np.concatenate([np.zeros((delay, *started.shape[1:])), started])
            return np.stack([*(padded[i : i + len(started)] for i in range(delay)), newest], axis=-2)

        self.remember("line", append, "sampled", begin=begin, keep=lambda line: line[..., 1:, :], over_time=lines)
        self.put_out("y", lambda line: line[..., 0, :], "line", unit=unit, **axes)


class StrainSensor(SensorBlock):
    """Samples the joints of one finger and outputs the readings of its strain sensors.

    ::

        joint_angles (N) rad ---> +--------------+ ---> strain           (R) readings
                                  | StrainSensor |
                                  +--------------+ ---> extension_ratio  (R) length over rest length, ahead of a
                                                                             response curve; of a SensorLayout

    Readings run path after path (inner, outer; only outer when one-sided), from the base to the tip. Of a finger that
    leaves its plane, `PathSensors` also take its other joints, see SensorBlock. The outputs hold their values between
    samples.
    """

    def __init__(self, layout: MeasurementModel, period: float):
        """Samples every `period` s, beginning at initialization, the sensors of a `SensorLayout` or `PathSensors`.

        Raises:
            InputError: if the sensors measure something else than strain.
        """
        if not measures_strain(layout):
            expected = "give sensors of strain; SensorBlock reads those of any kind"
            raise InputError("StrainSensor", "layout", layout.quantity, expected)
        super().__init__(layout, period)
