"""CreepTorque: the state of the plant -> the memory torque of a finger that creeps, as actuation of its model.

PressureSoftening beside it multiplies what goes in and what comes out, for a finger with a pressure law.
"""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem
from pydrake.systems.primitives import LinearSystem

from soft_gripper.arrays import Array
from soft_gripper.fingers.creep import recursion, shares
from soft_gripper.fingers.finger_parts import PressureLaw
from soft_gripper.fingers.plant_finger import PlantFinger


class CreepTorque(LinearSystem):
    """The internal angles z of a finger's B branches of creep at its N joints, see `creep`.

    ::

                                     +-------------+
        state (nq + nv) of plant --> | CreepTorque | ---> actuation (nu) N m, of the model's joints
                                     +-------------+

    Beside a continuous plant the state is z. Beside a discrete one it is what of z the present joint angles q do not
    decide, w = z - after q; then z is exact for angles that are linear over each step, and nothing is late:

        w' = kept w + (before + kept after) q ,    z = w + after q .

    All of it is one of Drake's linear systems, which run in C++. It begins with z = 0: straight, or bent just now.
    """

    def __init__(self, finger: PlantFinger):
        """The finger is in a finalized plant."""
        branches, time_step = finger.finger.creep, finger.plant.time_step()
        if time_step > 0:
            decay, before, self._after = recursion(branches, time_step)
            follow = before + decay * self._after
        else:
            times = np.array([branch.time for branch in branches])[:, None]
            decay, follow, self._after = -1 / times, 1 / times, 0 * times
        joints, angles = finger.finger.segments, finger.position_selector()
        stiffness = np.diag(finger.finger.stiffness)
        torques = finger.actuator_selector().T @ np.hstack([share * stiffness for share in shares(finger.finger)])
        super().__init__(
            A=np.diag(np.repeat(decay, joints)),
            B=np.vstack([gain * angles for gain in follow]),
            C=torques,
            D=torques @ np.vstack([gain * angles for gain in self._after]),
            time_period=time_step,
        )

    def set_internal_angles(self, context: Context, z: Array, q: Array) -> None:
        """Sets where the branches are, as a simulation begins.

        Args:
            context: of this system.
            z: internal angles, (B, N) rad: q for a finger that has been held so for long, 0 for one that was straight.
            q: joint angles in the plant's context, (N,) rad; of a finger with a pressure law both by its softening.
        """
        state = (z - self._after * q).ravel()
        if self.time_period() > 0:
            context.SetDiscreteState(state)
        else:
            context.SetContinuousState(state)


class PressureSoftening(LeafSystem):
    """A vector times what a pressure law says of how far the finger bends, P(p) / p, or divided by it.

    ::

        pressure (1) Pa ---> +-------------------+
                             | PressureSoftening | ---> product (size)
        factor (size) -----> +-------------------+
    """

    def __init__(self, law: PressureLaw, size: int, divides: bool):
        super().__init__()
        self._law, self._power = law, -1 if divides else 1
        self._pressure = self.DeclareVectorInputPort("pressure", 1)
        self._factor = self.DeclareVectorInputPort("factor", size)
        self.DeclareVectorOutputPort("product", size, self._calc_product, {self.all_input_ports_ticket()})

    def _calc_product(self, context: Context, output: BasicVector) -> None:
        softening = self._law.softening(self._pressure.Eval(context))
        output.SetFromVector(self._factor.Eval(context) * softening**self._power)
