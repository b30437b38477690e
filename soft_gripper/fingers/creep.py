"""Creep: the decay of a bent finger's stiffness, as internal angles of Maxwell branches.

Every joint has an internal angle z for each branch, which follows its angle q:

    dz_i/dt = (q - z_i) / time_i .

The spring of branch i is stretched by q - z_i alone, so that the balance of a joint of instantaneous stiffness k reads

    k q + d dq/dt = driving torque + sum of  share_i k z_i ,

the last of which is the memory torque: creep drives the finger as pressure does. This is a Prony series in the
convention of finite element programs (J. C. Simo, T. J. R. Hughes: *Computational Inelasticity*, 1998, chapter 10), and
for an angle that is linear between samples, z follows exactly (same, 10.3).

With a pressure law the finger bends s(p) = P(p) / p times as far as with the chamber law alone. The chamber widens,
which multiplies all bends, those of creep included:

    dz_i/dt = (q / s - z_i) / time_i ,    memory torque = s sum of  share_i k z_i .

So an emptied finger keeps as much of its bend as the same stress would have left in a finger without a law.

Leading axes are free; B branches, N joints.

CreepTorque: the state of the plant -> the memory torque of a finger that creeps, as actuation of its model.

PressureSoftening and SoftenedProduct scale its input and its output, for a finger with a pressure law.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.symbolic import Variable, if_then_else
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LinearSystem, Multiplexer, SymbolicVectorSystem

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import NO_PRESSURE, CreepBranch, PressureLaw
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock


class Recursion(NamedTuple):
    """z after a period = decay * z + old_gain * q before it + new_gain * q after it; (B, 1) each."""

    decay: Array
    old_gain: Array
    new_gain: Array


def recursion(branches: Sequence[CreepBranch], period: float) -> Recursion:
    """Gains of the recursion over a period, s; exact for angles that are linear over it."""
    periods = period / np.array([branch.time for branch in branches])[:, None]
    decay = np.exp(-periods)
    mean = -np.expm1(-periods) / periods  # the mean of exp(-t / time) over the period
    return Recursion(decay, mean - decay, 1 - mean)


def advance(branches: Sequence[CreepBranch], z: Array, old_angle: Array, new_angle: Array, period: float) -> Array:
    """Internal angles a period (s) later, (..., B, N) rad.

    Args:
        branches: B of them.
        z: internal angles, (..., B, N) rad.
        old_angle, new_angle: joint angles at the beginning and at the end of the period, (..., N) rad, linear between;
            give the same twice for constant angles. A finger with a pressure law has them divided by its softening.
        period: s.
    """
    decay, old_gain, new_gain = recursion(branches, period)
    return decay * z + old_gain * old_angle[..., None, :] + new_gain * new_angle[..., None, :]


def memory_torque(finger: Finger, z: Array, pressure: Array | float = 0.0) -> Array:
    """Torque of creep that drives the joints, (..., B, N) rad -> (..., N) N m, positive where it closes.

    `pressure`, (...) Pa, is that in the chamber; it matters only to a finger with a pressure law.
    """
    return finger.softening(pressure)[..., None] * (shares(finger) @ z * finger.stiffness)


def shares(finger: Finger) -> Array:
    """Fraction of the stiffness of every branch, (B,)."""
    return np.array([branch.share for branch in finger.creep])


class CreepTorque(LinearSystem):
    """The internal angles z of a finger's B branches of creep at its N joints, see `creep`.

    ::

                                     +-------------+
        state (nq + nv) of plant --> | CreepTorque | ---> actuation (nu) N m, of the model's joints
                                     +-------------+

    With a continuous plant the state is z. With a discrete one it is the part of z that does not depend on the present
    joint angles q, w = z - new_gain q; then z is exact for angles that are linear over each step, and nothing is late:

        w' = decay w + (old_gain + decay new_gain) q ,    z = w + new_gain q .

    It is one of Drake's linear systems, which run in C++. It begins with z = 0: straight, or just bent.
    """

    def __init__(self, finger: PlantFinger):
        """The finger is in a finalized plant."""
        branches, time_step = finger.finger.creep, finger.plant.time_step()
        if time_step > 0:
            decay, old_gain, self._new_gain = recursion(branches, time_step)
            follow = old_gain + decay * self._new_gain
        else:
            times = np.array([branch.time for branch in branches])[:, None]
            decay, follow, self._new_gain = -1 / times, 1 / times, 0 * times
        joints, angles = finger.finger.segments, finger.position_selector()
        stiffness = np.diag(finger.finger.stiffness)
        torques = finger.actuator_selector().T @ np.hstack([fraction * stiffness for fraction in shares(finger.finger)])
        super().__init__(
            A=np.diag(np.repeat(decay, joints)),
            B=np.vstack([gain * angles for gain in follow]),
            C=torques,
            D=torques @ np.vstack([gain * angles for gain in self._new_gain]),
            time_period=time_step,
        )

    def set_internal_angles(self, context: Context, z: Array, q: Array) -> None:
        """Sets the internal angles with which a simulation begins.

        Args:
            context: of this system.
            z: internal angles, (B, N) rad: q for a finger that has long been so, 0 for one that was straight.
            q: joint angles in the plant's context, (N,) rad; of a finger with a pressure law both by its softening.
        """
        state = (z - self._new_gain * q).ravel()
        if self.time_period() > 0:
            context.SetDiscreteState(state)
        else:
            context.SetContinuousState(state)


class PressureSoftening(Diagram):
    """Ratio of the bend with a finger's pressure law to that without, P(p) / p; see `PressureLaw.softening`.

    ::

                             +-------------------+
        pressure (1) Pa ---> | PressureSoftening | ---> softening (1)
                             +-------------------+

    Made of Drake's C++ blocks, since it runs at the plant's rate.
    """

    def __init__(self, law: PressureLaw):
        super().__init__()
        effective, pressure = Variable("effective"), Variable("pressure")
        divisor = if_then_else(abs(pressure) < NO_PRESSURE, 1.0, pressure)  # the branch not taken must not divide by 0
        ratio = if_then_else(abs(pressure) < NO_PRESSURE, float(law.softening(0.0)), effective / divisor)
        builder = DiagramBuilder()
        curves = PiecewiseLinear(law.curve.x[None], law.curve.y[None])
        curve = builder.AddNamedSystem("law", PiecewiseLinearBlock(curves))
        multiplexer = builder.AddNamedSystem("both", Multiplexer(2))
        softening = builder.AddNamedSystem("ratio", SymbolicVectorSystem(input=[effective, pressure], output=[ratio]))
        builder.ExportInput(curve.get_input_port(), "pressure")
        builder.ConnectInput("pressure", multiplexer.get_input_port(1))
        builder.Connect(curve.get_output_port(), multiplexer.get_input_port(0))
        builder.Connect(multiplexer.get_output_port(), softening.get_input_port())
        builder.ExportOutput(softening.get_output_port(), "softening")
        builder.BuildInto(self)


class SoftenedProduct(Diagram):
    """A vector times a finger's softening, or divided by it, in C++.

    ::

        softening (1) ---> +----------+
                           | SoftenedProduct | ---> product (size)
        factor (size) ---> +----------+
    """

    def __init__(self, size: int, divides: bool):
        super().__init__()
        softening = Variable("softening")
        factors = [Variable(f"factor_{i}") for i in range(size)]
        products = [factor / softening if divides else factor * softening for factor in factors]
        builder = DiagramBuilder()
        multiplexer = builder.AddNamedSystem("both", Multiplexer([1, size]))
        product = builder.AddNamedSystem("product", SymbolicVectorSystem(input=[softening, *factors], output=products))
        builder.Connect(multiplexer.get_output_port(), product.get_input_port())
        builder.ExportInput(multiplexer.get_input_port(0), "softening")
        builder.ExportInput(multiplexer.get_input_port(1), "factor")
        builder.ExportOutput(product.get_output_port(), "product")
        builder.BuildInto(self)
