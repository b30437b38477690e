"""The most probable shape in space and its uncertainty: the estimator `gaussian` of a finger that leaves its plane.

As in the plane (`gaussian`), the joints are Gaussian about those of the free finger, with the covariance of the torques
that a load may have. The forces are white along the finger, and one more presses on the tip, alike in three directions;
their torques follow from the bent chain, whose unit forces at the places k have at the joints the torques J_k,

    T = sum over k of  w_k J_k^T J_k ,

so that one force on a bent finger turns it sideways and twists it, and one way is inferred from the other. On a
straight finger T in bending is that of `torque_covariance`: two places on each link integrate over it exactly (Gauss
and Legendre), as the torques of forces on a link are linear in their places.

Prior, weight and readings  y = h(q) + noise  are linearized where the pass before has left the joints, the first one
at the free finger: iterated extended Kalman update (Bell and Cathey 1993, doi 10.1109/9.250476).

Leading axes are free; D joints, way after way (`MeasurementModel.ways`), N in each; R readings.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import SpatialShape
from soft_gripper.estimators.gaussian import TIP_SHARE, condition
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.spatial_chain import Posture, SpatialChain, posture, spatial_chain, vector_product
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel

_PASSES = 2
_GAUSS = np.array([-1.0, 1.0]) / np.sqrt(12)  # places on a link of length 1, from its middle


@dataclass(frozen=True)
class SpatialGaussianShape:
    """The estimator `gaussian` of one finger whose sensors see it leave its plane."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> SpatialShape:
        """The joint positions and their covariance.

        Args:
            readings: of the sensors, (..., R); NaN where there is none.
            driving: torque at the joints that is known before anything is read, (..., D) N m, and N where they slide.
            gravity: in B, (..., 3) m/s^2.
        """
        measured, variance = self.measured(readings)
        q = self._free(driving)
        for _ in range(_PASSES):
            at = self.posture(q)
            free, H = self._free(driving + self.weight(at, gravity)), self.layout.slopes(q)
            gain, covariance = condition(H, self.prior(at, q, driving), variance)
            left = measured - self.layout.predict(q) - (H @ (free - q)[..., None])[..., 0]
            q = free + (gain @ left[..., None])[..., 0]
        return SpatialShape(q, covariance)

    def measured(self, readings: Array) -> tuple[Array, Array]:
        """The measured quantity, 0 where nothing is read, and its variance, (..., R) each."""
        measured, assumed = self.layout.measured(readings), self.uncertainty
        read = np.isfinite(measured)
        measured = np.where(read, measured, 0.0)
        return measured, np.where(read, assumed.any_reading**2 + (assumed.gain * measured) ** 2, UNKNOWN)

    def posture(self, q: Array) -> Posture:
        """Of the chain at joint positions (..., D)."""
        return posture(self.chain, q[..., self.in_chain])

    def prior(self, at: Posture, q: Array, driving: Array) -> Array:
        """The covariance of the joints before the sensors are read, (..., D, D), about the posture of `q`."""
        load = self.compliance(q)[..., None] * self._torques(at)
        factors = np.concatenate([load, self._of_drive(q, driving)], axis=-1)
        return np.asarray(factors @ np.swapaxes(factors, -1, -2) + self.deviations)

    def of_model(self, q: Array, driving: Array) -> Array:
        """The part of the prior that is due to deviations of finger and pressure from the nominal model."""
        known = self._of_drive(q, driving)
        return np.asarray(known @ np.swapaxes(known, -1, -2) + self.deviations)

    def _of_drive(self, q: Array, driving: Array) -> Array:
        """Standard deviations of the joints due to bend per pressure and to pressure, (..., D, 2)."""
        compliance, assumed = self.compliance(q), self.uncertainty
        of_driving = compliance * (assumed.bend_per_pressure * driving)
        of_pressure = compliance * (assumed.pressure * self._pressure_gain)
        return np.stack(np.broadcast_arrays(of_driving, of_pressure), axis=-1)

    def compliance(self, q: Array) -> Array:
        """Of the joints, rad/(N m), and m/N where they slide, (D,) or, under an elastic law, (..., D)."""
        finger, compliance = self.layout.finger, 1 / self._stiffness
        if finger.elastic_law is None:
            return compliance
        found = np.broadcast_to(compliance, q.shape).copy()
        found[..., : finger.segments] = 1 / finger.joint_law.slope(q[..., : finger.segments])
        return found

    def unloaded(self, q: Array, driving: Array, gravity: Array) -> Array:
        """Joint positions under driving torque and weight alone, linearized about those of a bent finger, `q`."""
        finger, torque = self.layout.finger, driving + self.weight(self.posture(q), gravity)
        if finger.elastic_law is None:
            return self._free(torque)
        elastic = self._stiffness * q
        elastic[..., : finger.segments] = finger.elastic_torque(q[..., : finger.segments])
        return np.asarray(q + self.compliance(q) * (torque - elastic))

    def _free(self, torque: Array) -> Array:
        finger = self.layout.finger
        q = torque / self._stiffness
        if finger.elastic_law is not None:
            q[..., : finger.segments] = finger.angle(torque[..., : finger.segments])
        return np.asarray(q)

    def _torques(self, at: Posture) -> Array:
        """At the joints, of forces of one standard deviation at all places in three directions, (..., D, 3 K)."""
        frames, points, scale = self._places
        places = at.origins[..., frames, :] + points[:, None] * at.rotations[..., frames, :, :][..., 2]
        screws = at.screws[..., self.from_chain, None, :]
        moved = vector_product(screws[..., :3], places[..., None, :, :]) + screws[..., 3:]  # (..., D, K, 3)
        moved = moved * scale[..., None]
        return moved.reshape(*moved.shape[:-2], -1)

    def weight(self, at: Posture, gravity: Array) -> Array:
        """Torques of the weight at the joints, (..., D)."""
        x, z = self.layout.finger.links.center
        mass, R = self.layout.finger.links.mass, at.rotations[..., self.links, :, :]
        centres = at.origins[..., self.links, :] + x[:, None] * R[..., 0] + z[:, None] * R[..., 2]
        moments = self._carried @ (mass[:, None] * centres)  # of what lies beyond every joint
        forces, screws = (self._carried @ mass)[:, None] * gravity[..., None, :], at.screws
        turning = vector_product(moments, gravity[..., None, :])
        torques = (screws[..., :3] * turning + screws[..., 3:] * forces).sum(axis=-1)
        return np.asarray(torques[..., self.from_chain])

    @cached_property
    def chain(self) -> SpatialChain:
        return spatial_chain(self.layout.finger)

    @cached_property
    def from_chain(self) -> NDArray[np.int_]:
        """Joints of the chain in the order way after way, (D,)."""
        return np.argsort(self.in_chain)

    @cached_property
    def in_chain(self) -> NDArray[np.int_]:
        return self.chain.places(self.layout.ways)

    @cached_property
    def links(self) -> NDArray[np.int_]:
        """Frames that are fixed to the links, (N + 1,)."""
        return self.chain.beyond(np.arange(self.layout.finger.segments + 1))

    @cached_property
    def _carried(self) -> Array:
        """Whether a joint of the chain carries a link, (D, N + 1)."""
        return (self.links > np.arange(len(self.chain.ways))[:, None]).astype(float)

    @cached_property
    def _places(self) -> tuple[NDArray[np.int_], Array, Array]:
        """Frames of the K places of forces, their places along the links, (K,) m, and their scales, (D, K) N.

        The scale is 0 where a place is not moved by a joint. The last place is the tip.
        """
        finger, lengths = self.layout.finger, np.diff(self.layout.finger.link_ends)
        frames = np.append(np.repeat(self.links, 2), self.links[-1])
        points = np.append((lengths[:, None] * (0.5 + _GAUSS)).ravel(), lengths[-1])
        base = self.uncertainty.load_pressure * finger.pressure_gain.max()  # N m, torque of a usual load
        along = np.repeat(lengths / 2, 2) * 3 / finger.length**3
        forces = base * np.sqrt(np.append((1 - TIP_SHARE) * along, TIP_SHARE / finger.length**2))
        return frames, points, (frames > self.from_chain[:, None]) * forces

    @cached_property
    def _stiffness(self) -> Array:
        return np.concatenate([self.layout.finger.stiffnesses[way] for way in self.layout.ways])

    @cached_property
    def _pressure_gain(self) -> Array:
        """Of all chambers alike, in bending, (D,)."""
        finger = self.layout.finger
        return np.append(finger.pressure_gain, np.zeros(len(self._stiffness) - finger.segments))

    @cached_property
    def deviations(self) -> Array:
        """What else makes the joints differ from the nominal ones, (D, D); where they slide, as far over a segment."""
        finger, angle = self.layout.finger, self.uncertainty.angle
        each = [angle * finger.segment_length if way in SLIDES else angle for way in self.layout.ways]
        return np.diag(np.repeat(each, finger.segments) ** 2)
