"""WireStrain: lengths of wires -> strain of the sensors that estimators know, and lengths of the sections."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.wire_lengths import WireCalibration, as_strain
from soft_gripper.signals import describe

PATHS = ("inner", "outer")


class WireStrain(LeafSystem):
    """Reads an arm of S sections whose wires are calibrated.

    ::

                                +------------+ ---> strain           (2 x sections) as of an arm that only bends
        wire_lengths (2 x S) m  | WireStrain |
          [inner; outer] -----> +------------+ ---> section_lengths  (S) m

    Estimators bend a finger of constant length; how it lengthens goes past them, to StretchedArm. Stateless.
    """

    def __init__(self, calibration: WireCalibration, finger: Finger, sections: int):
        """`sections` of the strain sensors, which divides S."""
        super().__init__()
        self._calibration, self._finger, self._sections = calibration, finger, sections
        count = len(calibration.bend_offsets)
        self._wires = self.DeclareVectorInputPort("wire_lengths", 2 * count)
        describe(
            self.DeclareVectorOutputPort("strain", 2 * sections, self._calc_strain), path=PATHS, section=range(sections)
        )
        lengths = self.DeclareVectorOutputPort("section_lengths", count, self._calc_lengths)
        describe(lengths, "m", arm_section=range(count))

    def _calc_strain(self, context: Context, output: BasicVector) -> None:
        theta = self._calibration.sections(*self._sides(context)).theta
        output.SetFromVector(as_strain(self._finger, theta, self._sections)[1])

    def _calc_lengths(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._calibration.sections(*self._sides(context)).length)

    def _sides(self, context: Context) -> np.ndarray:
        return np.asarray(self._wires.Eval(context)).reshape(2, -1)
