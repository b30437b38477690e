"""ShapeEstimator: any ShapeFunction as a block."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.bending_plane import bending_plane
from soft_gripper.shape.driving_torque import DRIVING_TORQUE
from soft_gripper.shape.estimate import ContactForce, ShapeEstimate, ShapeFunction
from soft_gripper.shape.finger_shape import ANGLES
from soft_gripper.shape.position_band import position_std
from soft_gripper.signals import describe

CONTACT_UNITS = {"force": "N", "arc_length": "m", "force_std": "N", "arc_length_std": "m"}


class ShapeEstimator(LeafSystem):
    """Estimates the shape of one finger, and what else its function estimates.

    ::

        strain (paths * S) -------> +----------------+ ---> estimated_joint_angles  (N) rad
        driving_torque (N) N m ---> | ShapeEstimator | ---> joint_angle_covariance  (N x N) rad^2
        X_WB (12) [R | p] --------> |                | ---> position_std            (N + 1) m, of joints and tip across
                                    |                |                              the finger
                                    |                | ---> contact_force           (1) N, positive on the inner side
                                    |                | ---> contact_arc_length      (1) m, from the base
                                    |                | ---> contact_force_std       (1) N
                                    +----------------+ ---> contact_arc_length_std  (1) m

    Covariance and contact are there if the function gives them. Stateless.
    """

    def __init__(self, function: ShapeFunction, layout: SensorLayout, gravity: Array):
        """Sensors and finger as they are believed to be; `gravity` in the world, (3,) m/s^2, zero for none."""
        super().__init__()
        self._function, self._finger, self._gravity = function, layout.finger, gravity
        self._strain = self.DeclareVectorInputPort("strain", layout.readings)
        self._driving = self.DeclareVectorInputPort(DRIVING_TORQUE, layout.finger.segments)
        self._X_WB = self.DeclareVectorInputPort("X_WB", 12)
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc)
        self._estimate = self.DeclareCacheEntry("shape", producer, {self.all_input_ports_ticket()})
        straight = function(layout.response.reading(np.ones(layout.readings)), np.zeros(layout.finger.segments), 0j)
        self._declare_ports(straight)

    def _declare_ports(self, found: ShapeEstimate) -> None:
        joints = range(self._finger.segments)
        self._declare(ANGLES, lambda estimate: estimate.q, "rad", joint=joints)
        if found.covariance is not None:
            axes: dict[str, Sequence[Any]] = {"joint": joints, "joint_beside": joints}
            self._declare("joint_angle_covariance", lambda estimate: estimate.covariance, "rad^2", **axes)
            self._declare("position_std", self._band, "m", point=(*map(str, joints), "tip"))
        if found.contact is not None:
            for field in ContactForce._fields:
                self._declare(f"contact_{field}", _contact_field(field), CONTACT_UNITS[field])

    def _declare(
        self, name: str, part: Callable[[ShapeEstimate], Array | None], unit: str, **axes: Sequence[Any]
    ) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(np.ravel(np.asarray(part(self._estimate.Eval(context)))))

        size = int(np.prod([len(labels) for labels in axes.values()]))
        ticket = self.cache_entry_ticket(self._estimate.cache_index())
        describe(self.DeclareVectorOutputPort(name, size, calc, {ticket}), unit, **axes)

    def _band(self, estimate: ShapeEstimate) -> Array:
        assert estimate.covariance is not None
        return position_std(self._finger, estimate.q, estimate.covariance)

    def _calc(self, context: Context, value: AbstractValue) -> None:
        gravity = bending_plane(self._X_WB.Eval(context)).planar(self._gravity)
        value.set_value(self._function(self._strain.Eval(context), self._driving.Eval(context), gravity))


def _contact_field(field: str) -> Callable[[ShapeEstimate], Array]:
    return lambda estimate: getattr(estimate.contact, field)
