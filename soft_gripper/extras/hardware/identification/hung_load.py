"""A load that hangs on a string at the tip of a finger: it swings, and rubs at its hook.

The load keeps hanging down while the tip turns, so the hook slides on what it hangs on. Dry friction there is a torque
that is proportional to the weight, and independent of how fast the tip turns:

    torque = friction weight ,    friction = (coefficient of friction) (radius of the hook) ,

which takes a constant part of every swing, where viscous damping takes a share of it (J. P. Den Hartog: *Forced
vibrations with combined Coulomb and viscous friction*, Transactions of the ASME 53, 1931).

It is an actuator of Drake that brakes the hook, of limited effort, which a discrete plant solves implicitly: below the
limit, the hook sticks.
"""

from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    PdControllerGains,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger_parts import TipLoad

_MODEL_NAME = "hung_load"
_SLIP_RATE = 0.02  # rad/s, at which friction is at its limit


class HungLoad(NamedTuple):
    """A point mass on a string."""

    load: TipLoad  # at the place of its hook
    string: float  # m
    friction: float  # m, torque of friction at the hook over the weight

    def add_to(self, plant: MultibodyPlant, tip: Frame, gravity: Array) -> None:
        """Hangs the load at the tip of a finger, in the bending plane, before the plant is finalized.

        At angle 0 it hangs straight down from a straight finger.
        """
        model, weight = plant.AddModelInstance(_MODEL_NAME), self.load.mass * float(np.linalg.norm(gravity))
        center = self.string * gravity / np.linalg.norm(gravity)
        inertia = SpatialInertia(self.load.mass, center, UnitInertia(0, 0, 0).ShiftFromCenterOfMass(center))
        place = FixedOffsetFrame("hook", tip, RigidTransform([self.load.x, 0.0, self.load.z]), model)
        body, hook = plant.AddRigidBody(_MODEL_NAME, model, inertia), plant.AddFrame(place)
        joint = plant.AddJoint(RevoluteJoint(_MODEL_NAME, hook, body.body_frame(), [0, 1, 0]))
        if self.friction > 0:
            brake = plant.AddJointActuator(_MODEL_NAME, joint, self.friction * weight)
            brake.set_controller_gains(PdControllerGains(p=0.0, d=self.friction * weight / _SLIP_RATE))

    def connect(self, builder: DiagramBuilder, plant: MultibodyPlant) -> None:
        """Arms the brake, once the plant is finalized."""
        if self.friction > 0:
            rest_state = builder.AddSystem(ConstantVectorSource(np.zeros(2)))
            port = plant.get_desired_state_input_port(plant.GetModelInstanceByName(_MODEL_NAME))
            builder.Connect(rest_state.get_output_port(), port)
