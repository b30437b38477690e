"""The part of its bending stiffness that pressure takes from a finger, as a torque that drives its joints.

Pressure in a finger that can lengthen acts like an axial force on a column: it takes a share of the stiffness, and the
finger yields more to pressure, weight and touch alike. With the share t(p) of `PressureLaw.stiffness_taken`, the
balance of a joint of stiffness k reads

    k (1 - t(p)) q + d dq/dt = P(p) A e + weight + touch + memory torque ,

so that springs may keep k: what pressure takes is one more driving torque,  t(p) k q . The plant computes it from its
state, an estimator from its estimate; both are those of `taken_torque`.

Leading axes are free; N joints.
"""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.fingers.creep import SoftenedProduct
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock


def taken_torque(finger: Finger, q: Array, pressure: Array | float) -> Array:
    """Torque with which a pressure, (...) Pa, drives joints at q, (..., N) rad, further, (..., N) N m."""
    return finger.share_taken(pressure)[..., None] * (finger.stiffness * q)


class TakenStiffness(Diagram):
    """`taken_torque` of a finger in a plant, as actuation of its model.

    ::

        state (nq + nv) of plant ---> +----------------+
        pressure (1) Pa ------------> | TakenStiffness | ---> actuation (nu) N m, of the model's joints
                                      +----------------+

    Made of Drake's C++ blocks, since it runs at the plant's rate.
    """

    def __init__(self, finger: PlantFinger):
        """The finger is in a finalized plant, and has a pressure law."""
        super().__init__()
        law = finger.finger.pressure_law
        assert law is not None
        builder = DiagramBuilder()
        curve = PiecewiseLinear(law.taken_fraction.x[None], law.taken_fraction.y[None])
        fraction = builder.AddNamedSystem("share", PiecewiseLinearBlock(curve))
        stiffness = finger.finger.stiffness[:, None] * finger.position_selector()
        stiffness_map = np.ascontiguousarray(finger.actuator_selector().T @ stiffness)
        elastic = builder.AddNamedSystem("elastic", MatrixGain(stiffness_map))
        lost_torque = builder.AddNamedSystem("taken", SoftenedProduct(len(stiffness_map), divides=False))
        builder.Connect(fraction.get_output_port(), lost_torque.GetInputPort("softening"))
        builder.Connect(elastic.get_output_port(), lost_torque.GetInputPort("factor"))
        builder.ExportInput(elastic.get_input_port(), "state")
        builder.ExportInput(fraction.get_input_port(), "pressure")
        builder.ExportOutput(lost_torque.get_output_port(), "actuation")
        builder.BuildInto(self)
