"""PeakForce: how hard fingers have pressed on what they touch, at worst."""

import math
from collections.abc import Mapping

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, DiscreteValues, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.truth.contact import patches

PERIOD = 0.02  # s: what presses through a finger takes several times as long to rise and fall


def normal_forces(results: ContactResults, finger_of: Mapping[int, int], fingers: int) -> Array:
    """What presses on each finger along the normals of its contacts with all but itself, (fingers) N."""
    forces = np.zeros(fingers)
    for patch in patches(results, finger_of):
        first, second = map(finger_of.get, patch.shapes)
        pressed = abs(patch.force @ patch.normal) / math.hypot(*patch.normal)
        for finger in (first, second):
            if finger is not None and first != second:
                forces[finger] += pressed
    return forces


class PeakForce(LeafSystem):
    """Looks at the contacts every PERIOD.

    ::

        contact_results ---> +-----------+ ---> force (F) N, of each finger, now
                             | PeakForce | ---> peak  (F) N, the largest sample since the beginning
                             +-----------+
    """

    def __init__(self, finger_of: Mapping[int, int], fingers: int):
        """`finger_of` says whose a shape is, by the value of its GeometryId."""
        super().__init__()
        self._finger_of, self._fingers = dict(finger_of), fingers
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self.DeclareVectorOutputPort("force", fingers, self._calc, {self._results.ticket()})
        self.DeclareStateOutputPort("peak", self.DeclareDiscreteState(fingers))
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._now(context))

    def _update(self, context: Context, values: DiscreteValues) -> None:
        values.set_value(np.maximum(context.get_discrete_state_vector().value(), self._now(context)))

    def _now(self, context: Context) -> Array:
        return normal_forces(self._results.Eval(context), self._finger_of, self._fingers)


def add_peak_force(builder: DiagramBuilder, station: StationParts) -> PeakForce:
    """Adds `peak_force` for the fingers of a station."""
    plant = station.plant
    finger_of = {
        shape.get_value(): number
        for number, finger in enumerate(station.fingers)
        for link in finger.links
        for shape in plant.GetCollisionGeometriesForBody(link)
    }
    block = PeakForce(finger_of, len(station.fingers))
    builder.AddNamedSystem("peak_force", block)
    builder.Connect(plant.get_contact_results_output_port(), block.get_input_port())
    return block
