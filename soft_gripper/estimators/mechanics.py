"""Mechanics of a nominal finger: torques at its joints, and the prior of its joint positions.

At every joint the elastic torque balances driving torque, weight and load,  k q = u + w + tau , so that the joints are
Gaussian about those of the free finger, with the covariance

    P = C T C + sum of r_n^2 (C p_n u) (C p_n u)^T + d^2 C g (C g)^T + a^2 I ,   C = diag(1 / k) ,

with T the covariance of the torques of a load, r_n the standard deviations of the bend that the driving torque leads
to, as shares, p_n the Legendre polynomials of degree 0 to 2 along the finger, d the standard deviation of the pressure,
whose gain is g, and a that of everything else.

The forces of a load are white noise along the finger, and one more, independent, presses on the tip; they act in all
directions on the bent chain, so that one force on a bent finger turns it sideways and twists it, and one deformation is
inferred from the other. With B_i (p, 1) the motion of a place p by the joint i, and w_k the variances of the forces at
the places p_k,

    T_ij = sum of w_k B_i (p_k, 1) . B_j (p_k, 1)  =  trace B_i (sum of w_k (p_k, 1) (p_k, 1)^T) B_j^T ,

over the places beyond the outer of both joints, of which the sum in brackets is the same for all joints inside it. Two
places on each link integrate over it exactly (Gauss and Legendre). If the finger only bends, the same sums are taken in
its plane (`bending_plane`).

On a straight finger contact forces f(x) have at the arc length s the torque

    tau(s) = integral from s to L of (x - s) f(x) dx .

The forces along the finger give it the covariance of twice integrated white noise, with u the distance from the tip
over the length,

    m^2 (3 M - m) / 2 ,   m = min(u, v) ,  M = max(u, v) ,

and the force on the tip gives it u v; each is 1 at the base. What is most probable between readings under the first
alone is a cubic spline (Wahba 1978, doi 10.1111/j.2517-6161.1978.tb01050.x).

Leading axes are free; N segments, D joints, one deformation after the other (`MeasurementModel.deformations`), D = N if
the finger only bends.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.batches import memoized
from soft_gripper.estimators.bending_plane import PointsInPlane
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.spatial_chain import Posture, SpatialChain, posture
from soft_gripper.sensors.calibrated_states import CalibratedStates, StateDistances
from soft_gripper.sensors.measurement import MeasurementModel

_MODES_PER_AXIS = 5  # modes of a load in each direction
TIP_FRACTION = 0.3  # fraction of the variance at the base due to a force on the tip
_MIN_VARIANCE_RATIO = 1e-9  # minimum variance of a mode, over that of the largest force and the length
_GAUSS_NODES = np.array([-1.0, 1.0]) / np.sqrt(12)  # nodes on a link of length 1, from its middle


class _Points(NamedTuple):
    """Points of the links: K places of forces, the last of them the tip, or the N + 1 middles of the masses."""

    frames: NDArray[np.int_]  # (K)
    places: Array  # (p, 1) in these frames, (K, 4, 1) m
    weights: Array  # N^2, variances of the forces, (K), or masses, kg

    def positions(self, posture: Posture) -> Array:
        """Positions (p, 1) in B, (..., K, 4) m."""
        return np.asarray((posture.frames[..., self.frames, :, :] @ self.places)[..., 0])

    def to_plane(self, link_ends: Array) -> PointsInPlane:
        """The points in the bending plane, by link."""
        return PointsInPlane(link_ends, self.frames, self.places[:, 2, 0] + 1j * self.places[:, 0, 0], self.weights)


class ExtrapolationStd(NamedTuple):
    """Standard deviations of errors of a calibrated finger away from its fitted states (`CalibratedStates`)."""

    pressure: Array  # (...) Pa
    values: Array  # (..., S) of the values that are read


@dataclass(frozen=True, eq=False)
class BentFinger:
    """Posture of the chain of a finger, and motions of its joints; each is computed when it is read."""

    mechanics: "Mechanics"
    q: Array  # joint positions, (..., D)

    @cached_property
    def posture(self) -> Posture:
        mechanics = self.mechanics
        return posture(mechanics.chain, self.q if mechanics.is_planar else self.q[..., mechanics.to_chain])

    @cached_property
    def motions(self) -> Array:
        """Motions B of the joints, deformation after deformation, (..., D, 12), each 3 x 4."""
        return self.mechanics.to_position_order(self.posture.motions)

    @cached_property
    def directions(self) -> Planar:
        """Directions of the links beyond the joints of a finger that only bends, z + i x, (..., N)."""
        headings, directions = self.q.cumsum(axis=-1), np.empty(self.q.shape, complex)
        directions.real, directions.imag = np.cos(headings), np.sin(headings)
        return directions


@dataclass(frozen=True)
class Mechanics:
    """Mechanics of one nominal finger; gravity is a vector in B, (..., 3) m/s^2."""

    layout: MeasurementModel
    uncertainty: Uncertainty

    def bent_finger(self, q: Array) -> BentFinger:
        return BentFinger(self, q)

    def to_position_order(self, joint_matrices: Array) -> Array:
        """Reorders matrices of the chain's joints, (..., J, 3, 4), to flat ones by deformation, (..., D, 12)."""
        rows = joint_matrices.reshape(*joint_matrices.shape[:-2], 12)
        return rows if self.is_planar else rows[..., self.from_chain, :]

    def weight(self, bent: BentFinger, gravity: Array) -> Array:
        """Torques of the weight in a posture, (..., D)."""
        if self.is_planar:
            base_gravity = gravity[..., 2] + 1j * gravity[..., 0]
            return np.asarray((self._planar_masses.sums(bent.directions).conj() * base_gravity[..., None]).imag)
        points, carried_masses = self._masses
        moments = carried_masses @ points.positions(bent.posture)  # (..., D, 4)
        products = gravity[..., None, :, None] * moments[..., None, :]
        return np.asarray((bent.motions * products.reshape(*products.shape[:-2], 12)).sum(axis=-1))

    def load_covariance(self, bent: BentFinger, q: Array) -> Array:
        """Covariance of the joints due to a load, C T C, in the posture of `q`, (..., D, D)."""
        inner_covariance = (
            self._planar_forces.covariance(bent.directions) if self.is_planar else self._inner_covariance(bent)
        )
        covariance = np.where(self._is_inner, inner_covariance, np.swapaxes(inner_covariance, -1, -2))
        return np.asarray(outer(self.compliance(q)) * covariance)

    def _inner_covariance(self, bent: BentFinger) -> Array:
        """Covariance of load torques, (..., D, D); correct where the row's joint is the inner one."""
        points = self._forces.positions(bent.posture)
        motions = bent.posture.motions
        N = self.layout.finger.segments
        products = (points[..., :, None] * points[..., None, :]).reshape(*points.shape[:-1], 16)
        outer_products = (self._outer_weights @ products).reshape(*products.shape[:-2], N, 4, 4)
        segment_motions = motions.reshape(*motions.shape[:-3], N, motions.shape[-3] // N * 3, 4)
        torque_products = self.to_position_order((segment_motions @ outer_products).reshape(motions.shape))
        return np.asarray(bent.motions @ np.swapaxes(torque_products, -1, -2))

    def load_modes(self, bent: BentFinger) -> Array:
        """Torques of the strongest modes of a load in a posture, (..., D, M) or (D, M).

        The modes are of forces that turn with the links, so that a mode means the same however far the finger is bent.
        On the straight finger they are the modes of the load across it in each plane, and along it if it stretches.
        A finger that only bends keeps those of the straight one: they couple no deformations, and a filter that
        followed them while it bends would seem to observe modes that it never does.
        """
        return self._straight_modes if self.is_planar else self._modes_at(bent)

    @cached_property
    def _straight_modes(self) -> Array:
        return self._modes_at(self.bent_finger(self.layout.straight))

    @cached_property
    def weak_modes(self) -> Array:
        """Torques of all weaker modes of a load, of one standard deviation each, on the straight finger, (D, W)."""
        variances, forces = self._mode_basis(slice(_MODES_PER_AXIS, None))
        return self._torques_of_forces(forces, self.bent_finger(self.layout.straight)) * np.sqrt(variances)

    def _modes_at(self, bent: BentFinger) -> Array:
        return self._torques_of_forces(self._strong_mode_basis[1], bent)

    def _torques_of_forces(self, forces: Array, bent: BentFinger) -> Array:
        """Torques at the joints, (..., D, M), of M sets of forces along x, y and z of the links, (3 K, M) N."""
        torques = self._unit_torques(bent)
        return np.asarray(torques.reshape(*torques.shape[:-2], 3 * len(self._forces.frames)) @ forces)

    @property
    def load_variances(self) -> Array:
        """Variances of these modes before the sensors are read, (M,)."""
        return self._strong_mode_basis[0]

    @cached_property
    def _strong_mode_basis(self) -> tuple[Array, Array]:
        return self._mode_basis(slice(_MODES_PER_AXIS))

    def _mode_basis(self, ranks: slice) -> tuple[Array, Array]:
        """Variances of the modes of these ranks, and the forces of each along x, y and z of the links, (3 K, M) N.

        Rank 0 is the strongest along each axis. With L = T_d w^1/2 the torques of forces along one of the axes, of one
        standard deviation each, the forces  w^1/2 L^T V / values  have the torques  L L^T V / values = V .
        """
        straight = self._unit_torques(self.bent_finger(self.layout.straight))
        stds, forces_of_modes, variances = np.sqrt(self._forces.weights), [], []
        for axis in range(3):
            L = straight[..., axis, :] * stds
            values, modes = (array[..., ::-1][..., ranks] for array in np.linalg.eigh(L @ L.T))
            is_kept = values > _MIN_VARIANCE_RATIO * self._forces.weights.max() * self.layout.finger.length**2
            forces = np.zeros((3, len(stds), int(is_kept.sum())))
            forces[axis] = stds[:, None] * (L.T @ modes[:, is_kept]) / values[is_kept]
            forces_of_modes.append(forces.reshape(3 * len(stds), forces.shape[-1]))
            variances.append(values[is_kept])
        return np.concatenate(variances), np.concatenate(forces_of_modes, axis=-1)

    def _unit_torques(self, bent: BentFinger) -> Array:
        """Torques at the joints of forces of 1 N along x, y and z of the links at all places, (..., D, 3, K) N m."""
        frames, points = self._forces.frames, self._forces.positions(bent.posture)
        axes = np.moveaxis(bent.posture.rotations[..., frames, :, :], -1, -3)  # (..., 3, K, 3)
        forces = (axes[..., None] * points[..., None, :, None, :]).reshape(*axes.shape[:-3], 3 * len(frames), 12)
        torques = bent.motions @ np.swapaxes(forces, -1, -2)
        is_moved = (frames > self.from_chain[:, None])[:, None, :]
        return np.asarray(torques.reshape(*torques.shape[:-1], 3, len(frames)) * is_moved)

    @cached_property
    def chain(self) -> SpatialChain:
        """The chain, as far as the sensors see it yield."""
        layout = self.layout
        return SpatialChain.from_yields(layout.finger.segments, layout.finger.segment_length, layout.deformations)

    @cached_property
    def is_planar(self) -> bool:
        """Whether the finger stays in its plane, as far as the sensors see."""
        return self.layout.deformations == ("bending",)

    @cached_property
    def from_chain(self) -> NDArray[np.int_]:
        """Joints of the chain in the order of positions, deformation after deformation, (D,)."""
        return np.argsort(self.to_chain)

    @cached_property
    def to_chain(self) -> NDArray[np.int_]:
        return self.chain.position_indices(self.layout.deformations)

    @cached_property
    def links(self) -> NDArray[np.int_]:
        """Frames that are fixed to the links, (N + 1,)."""
        return self.chain.link_frames(np.arange(self.layout.finger.segments + 1))

    @cached_property
    def _is_inner(self) -> NDArray[np.bool_]:
        """Whether a joint lies before another one in the chain, or is the same, (D, D)."""
        return self.from_chain[:, None] <= self.from_chain

    @cached_property
    def _forces(self) -> _Points:
        finger, lengths = self.layout.finger, np.diff(self.layout.finger.link_ends)
        base_torque = self.uncertainty.load_pressure * finger.pressure_gain.max()  # N m, torque of a usual load
        densities = np.repeat(lengths / 2, 2) * 3 / finger.length**3
        variances = base_torque**2 * np.append((1 - TIP_FRACTION) * densities, TIP_FRACTION / finger.length**2)
        places = np.append((lengths[:, None] * (0.5 + _GAUSS_NODES)).ravel(), lengths[-1])
        frames = np.append(np.repeat(self.links, 2), self.links[-1])
        return _Points(frames, _local_points(0.0 * places, places), variances)

    @cached_property
    def _outer_weights(self) -> Array:
        """Variances of the forces, (N, K) N^2; 0 where the joints of a segment do not move the place."""
        return (self._forces.frames > self.links[:-1, None]) * self._forces.weights

    @cached_property
    def _masses(self) -> tuple[_Points, Array]:
        """Middles of the links, and the masses that each joint carries, (D, N + 1) kg."""
        links = self.layout.finger.links
        x, z = links.center
        carried_masses = (self.links > self.from_chain[:, None]) * links.mass
        return _Points(self.links, _local_points(x, z), links.mass), carried_masses

    @cached_property
    def _planar_forces(self) -> PointsInPlane:
        return self._forces.to_plane(self.layout.finger.link_ends)

    @cached_property
    def _planar_masses(self) -> PointsInPlane:
        return self._masses[0].to_plane(self.layout.finger.link_ends)

    def prior(
        self, bent: BentFinger, q: Array, driving: Array, extrapolation: "ExtrapolationStd | None" = None
    ) -> Array:
        """The covariance P of the joints before the sensors are read, (..., D, D), about the posture of `q`."""
        return self.load_covariance(bent, q) + self.model_covariance(q, driving, extrapolation)

    def model_covariance(self, q: Array, driving: Array, extrapolation: "ExtrapolationStd | None" = None) -> Array:
        """Part of P due to deviations of finger and pressure from the nominal model, (..., D, D)."""
        compliance = self.compliance(q)
        driving_changes = (compliance * driving)[..., None, :] * self.bend_changes
        covariance = np.swapaxes(driving_changes, -1, -2) @ driving_changes
        covariance += self._linear_other_covariance if self._is_linear else self._other_covariance(compliance)
        if extrapolation is not None:
            covariance = covariance + outer(compliance * (extrapolation.pressure[..., None] * self.pressure_gain))
        return covariance

    def extrapolation(self, readings: Array, driving: Array, gravity: Array) -> "ExtrapolationStd | None":
        """Extrapolation error away from the states of the calibration; None if the finger is not calibrated."""
        states = self.layout.calibrated
        if states is None:
            return None
        quantities = self.layout.measured(readings)
        return self.extrapolation_at(states, memoized(CalibratedStates.distances, states, quantities, driving, gravity))

    def extrapolation_at(self, states: CalibratedStates, distances: StateDistances) -> "ExtrapolationStd":
        """Extrapolation error at distances from the states."""
        drive_errors, section_errors = states.errors(distances)
        sensitivity = np.abs(self.layout.sensitivity).max(axis=0)
        return ExtrapolationStd(drive_errors / self._strain_per_pressure, section_errors / sensitivity)

    def scale_covariance(self, q: Array) -> Array | float:
        """Covariance of the scale of finger and sensors, at angles `q`, (..., D, D); 0 if not calibrated.

        It has a constant part and one linear along the finger; neither changes the readings.
        """
        states = self.layout.calibrated
        if states is None:
            return 0.0
        finger = self.layout.finger
        positions = np.tile(2 * finger.joint_arc_lengths / finger.length - 1, len(self.layout.deformations))
        return outer(states.bend_std * q) + outer(states.variation_std * positions * q)

    @cached_property
    def _strain_per_pressure(self) -> float:
        """Change of the reading that the pressure moves most, at the straight finger, 1/Pa."""
        return float(np.abs(self.layout.jacobian @ (self._linear_compliance * self.pressure_gain)).max())

    def compliance(self, q: Array) -> Array:
        """Compliance of the joints, rad/(N m), and m/N where they slide, (D,) or, under an elastic law, (..., D)."""
        if self._is_linear:
            return self._linear_compliance
        finger = self.layout.finger
        compliance = np.broadcast_to(self._linear_compliance, q.shape).copy()
        compliance[..., : finger.segments] = 1 / finger.joint_law.slope(q[..., : finger.segments])
        return compliance

    def positions_under(self, torque: Array) -> Array:
        """Joint positions at which the elastic torque is `torque`, (..., D)."""
        if self._is_linear:
            return torque / self.stiffness
        finger, q = self.layout.finger, torque / self.stiffness
        q[..., : finger.segments] = finger.angle(torque[..., : finger.segments])
        return np.asarray(q)

    def linearized_positions(self, q: Array, torque: Array) -> Array:
        """Joint positions under a known torque alone, linearized about those of a bent finger, `q`, (..., D)."""
        if self._is_linear:
            return self.positions_under(torque)
        finger, elastic = self.layout.finger, self.stiffness * q
        elastic[..., : finger.segments] = finger.elastic_torque(q[..., : finger.segments])
        return np.asarray(q + self.compliance(q) * (torque - elastic))

    @cached_property
    def bend_changes(self) -> Array:
        """Changes of the bend at the joints as fractions, (3, D): independent, of one standard deviation each.

        They are Legendre polynomials of degree 0 to 2 along the finger, from -1 at the base to 1 at the tip.
        """
        finger, stds = self.layout.finger, self.uncertainty.bend_stds
        polynomials = np.polynomial.legendre.legvander(2 * finger.joint_arc_lengths / finger.length - 1, len(stds) - 1)
        return np.tile(stds[:, None] * polynomials.T, len(self.layout.deformations))

    @property
    def usual_force(self) -> float:
        """Force on the middle of the finger that has the torque of a usual load at the base, N."""
        finger = self.layout.finger
        return float(self.uncertainty.load_pressure * finger.pressure_gain.max() / (finger.length / 2))

    @cached_property
    def pressure_gain(self) -> Array:
        """Gain of the pressure of all chambers alike, in bending, (D,)."""
        finger = self.layout.finger
        return np.append(finger.pressure_gain, np.zeros(len(self.stiffness) - finger.segments))

    @cached_property
    def deviations(self) -> Array:
        """Covariance of further deviations from the nominal joints, (D, D); of sliding ones per segment."""
        finger, angle = self.layout.finger, self.uncertainty.angle
        names = self.layout.deformations
        stds = [angle * finger.segment_length if name in SLIDES else angle for name in names]
        return np.diag(np.repeat(stds, finger.segments) ** 2)

    def _other_covariance(self, compliance: Array) -> Array:
        return outer(compliance * (self.uncertainty.pressure * self.pressure_gain)) + self.deviations

    @cached_property
    def _linear_other_covariance(self) -> Array:
        return self._other_covariance(self._linear_compliance)

    @cached_property
    def _is_linear(self) -> bool:
        return self.layout.finger.elastic_law is None

    @cached_property
    def stiffness(self) -> Array:
        """Stiffness of every joint, N m/rad, and N/m where it slides, (D,)."""
        return np.concatenate([self.layout.finger.stiffnesses[deformation] for deformation in self.layout.deformations])

    @cached_property
    def _linear_compliance(self) -> Array:
        return np.asarray(1 / self.stiffness)


def _local_points(x: Array, z: Array) -> Array:
    """Points (p, 1) of the bending plane, (K, 4, 1)."""
    return np.stack([x, 0.0 * z, z, np.ones(z.shape)], axis=-1)[..., None]


def outer(vector: Array) -> Array:
    """Outer product, (..., N) -> (..., N, N)."""
    return vector[..., :, None] * vector[..., None, :]
