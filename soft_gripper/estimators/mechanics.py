"""Mechanics of a nominal finger: what moves its joints, and how well that is known before its sensors are read.

At every joint the elastic torque balances driving torque, weight and load,  k q = u + w + tau , so that the joints are
Gaussian about those of the free finger, with the covariance

    P = C T C + sum of r_n^2 (C p_n u) (C p_n u)^T + d^2 C g (C g)^T + a^2 I ,   C = diag(1 / k) ,

with T the covariance of the torques of a load, r_n the standard deviations of the bend that the driving torque leads
to, as shares, p_n the Legendre polynomials of degree 0 to 2 along the finger, d the standard deviation of the pressure,
whose gain is g, and a that of everything else.

What is known of a load: its forces are white noise along the finger, and one more, independent, presses on the tip;
they act in all directions on the bent chain, so that one force on a bent finger turns it sideways and twists it, and
one way is inferred from the other. With B_i (p, 1) the motion of a place p by the joint i, and w_k the variances of the
forces at the places p_k,

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

Leading axes are free; N segments, D joints, way after way (`MeasurementModel.ways`): D = N if the finger only bends.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.batches import shared
from soft_gripper.estimators.bending_plane import PointsInPlane
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.spatial_chain import Posture, SpatialChain, posture
from soft_gripper.sensors.calibrated_states import CalibratedStates, StateDistances
from soft_gripper.sensors.measurement import MeasurementModel

_MODES = 5  # of a load in each direction
TIP_SHARE = 0.3  # fraction of the variance at the base that is due to a force on the tip
_NEGLIGIBLE = 1e-9  # share of a variance
_GAUSS = np.array([-1.0, 1.0]) / np.sqrt(12)  # places on a link of length 1, from its middle


class _Points(NamedTuple):
    """Points of the links: K places of forces, the last of them the tip, or the N + 1 middles of the masses."""

    frames: NDArray[np.int_]  # (K)
    places: Array  # (p, 1) in these frames, (K, 4, 1) m
    weights: Array  # N^2, variances of the forces, (K), or masses, kg

    def at(self, chain: Posture) -> Array:
        """(p, 1) in B, (..., K, 4) m."""
        return np.asarray((chain.frames[..., self.frames, :, :] @ self.places)[..., 0])

    def in_plane(self, link_ends: Array) -> PointsInPlane:
        """Of a finger that only bends, whose frames are its links."""
        return PointsInPlane(link_ends, self.frames, self.places[:, 2, 0] + 1j * self.places[:, 0, 0], self.weights)


class Away(NamedTuple):
    """Standard deviations of errors that a calibrated finger has away from its fitted states (`CalibratedStates`)."""

    pressure: Array  # (...) Pa
    values: Array  # (..., S) of the values that are read


@dataclass(frozen=True, eq=False)
class BentFinger:
    """The posture of the chain of a finger, and how its joints move it; each is computed when it is read."""

    mechanics: "Mechanics"
    q: Array  # joint positions, (..., D)

    @cached_property
    def chain(self) -> Posture:
        """The posture of the chain."""
        mechanics = self.mechanics
        return posture(mechanics.chain, self.q if mechanics.only_bends else self.q[..., mechanics.in_chain])

    @cached_property
    def motions(self) -> Array:
        """B of the joints, way after way, (..., D, 12), each 3 x 4."""
        return self.mechanics.by_way(self.chain.motions)

    @cached_property
    def directions(self) -> Planar:
        """Directions of the links beyond the joints of a finger that only bends, z + i x, (..., N)."""
        headings, found = self.q.cumsum(axis=-1), np.empty(self.q.shape, complex)
        found.real, found.imag = np.cos(headings), np.sin(headings)
        return found


@dataclass(frozen=True)
class Mechanics:
    """Mechanics of one nominal finger; gravity is a vector in B, (..., 3) m/s^2."""

    layout: MeasurementModel
    uncertainty: Uncertainty

    def posture(self, q: Array) -> BentFinger:
        """Where the chain lies at joint positions (..., D)."""
        return BentFinger(self, q)

    def by_way(self, by_joint: Array) -> Array:
        """Matrices of the joints of the chain, (..., J, 3, 4), way after way and flat, (..., D, 12)."""
        flat = by_joint.reshape(*by_joint.shape[:-2], 12)
        return flat if self.only_bends else flat[..., self.from_chain, :]

    def weight(self, at: BentFinger, gravity: Array) -> Array:
        """Torques of the weight in a posture, (..., D)."""
        if self.only_bends:
            pull = gravity[..., 2] + 1j * gravity[..., 0]
            return np.asarray((self._masses_in_plane.sums(at.directions).conj() * pull[..., None]).imag)
        points, carried_by = self._masses
        carried = carried_by @ points.at(at.chain)  # (..., D, 4)
        pulled = gravity[..., None, :, None] * carried[..., None, :]
        return np.asarray((at.motions * pulled.reshape(*pulled.shape[:-2], 12)).sum(axis=-1))

    def of_load(self, at: BentFinger, q: Array) -> Array:
        """The covariance of the joints due to a load, C T C, in the posture of `q`, (..., D, D)."""
        by_inner = self._forces_in_plane.covariance(at.directions) if self.only_bends else self._load_by_inner(at)
        # Right where the joint of the row is the inner one; the other half is its mirror image.
        found = np.where(self._is_inner, by_inner, np.swapaxes(by_inner, -1, -2))
        return np.asarray(outer(self.compliance(q)) * found)

    def _load_by_inner(self, at: BentFinger) -> Array:
        placed, motions, N = self._forces.at(at.chain), at.chain.motions, self.layout.finger.segments
        products = (placed[..., :, None] * placed[..., None, :]).reshape(*placed.shape[:-1], 16)
        beyond = (self._beyond @ products).reshape(*products.shape[:-2], N, 4, 4)
        of_segments = motions.reshape(*motions.shape[:-3], N, motions.shape[-3] // N * 3, 4)
        with_all_beyond = self.by_way((of_segments @ beyond).reshape(motions.shape))
        return np.asarray(at.motions @ np.swapaxes(with_all_beyond, -1, -2))

    def load_modes(self, at: BentFinger) -> Array:
        """Torques of the strongest modes of a load in a posture, (..., D, M) or (D, M).

        The modes are of forces that turn with the links, so that a mode means the same however far the finger is bent.
        On the straight finger they are the modes of the load across it in each plane, and along it if it stretches.
        Of a finger that only bends they are always those of the straight one: they couple no ways, and a filter that
        follows them while it bends would believe to read modes that it never does.
        """
        return self._straight_modes if self.only_bends else self._modes_at(at)

    @cached_property
    def _straight_modes(self) -> Array:
        return self._modes_at(self.posture(self.layout.straight))

    def _modes_at(self, at: BentFinger) -> Array:
        torques = self._unit_torques(at)
        return np.asarray(torques.reshape(*torques.shape[:-2], 3 * len(self._forces.frames)) @ self._strongest[1])

    @property
    def load_variances(self) -> Array:
        """Variances of these modes before the sensors are read, (M,)."""
        return self._strongest[0]

    @cached_property
    def _strongest(self) -> tuple[Array, Array]:
        """Variances of the modes, and the forces of each along x, y and z of the links at all places, (3 K, M) N.

        With L = T_d w^1/2 the torques of forces along one of the axes, of one standard deviation each, the forces
        w^1/2 L^T V / values  have the torques  L L^T V / values = V .
        """
        straight = self._unit_torques(self.posture(self.layout.straight))
        stds, found, variances = np.sqrt(self._forces.weights), [], []
        for axis in range(3):
            L = straight[..., axis, :] * stds
            values, modes = _strongest(L @ L.T)
            kept = values > _NEGLIGIBLE * self._forces.weights.max() * self.layout.finger.length**2
            forces = np.zeros((3, len(stds), int(kept.sum())))
            forces[axis] = stds[:, None] * (L.T @ modes[:, kept]) / values[kept]
            found.append(forces.reshape(3 * len(stds), forces.shape[-1]))
            variances.append(values[kept])
        return np.concatenate(variances), np.concatenate(found, axis=-1)

    def _unit_torques(self, at: BentFinger) -> Array:
        """At the joints, of forces of 1 N along x, y and z of the links at all places, (..., D, 3, K)."""
        frames, placed = self._forces.frames, self._forces.at(at.chain)
        axes = np.moveaxis(at.chain.rotations[..., frames, :, :], -1, -3)  # (..., 3, K, 3)
        forces = (axes[..., None] * placed[..., None, :, None, :]).reshape(*axes.shape[:-3], 3 * len(frames), 12)
        torques = at.motions @ np.swapaxes(forces, -1, -2)
        moved = (frames > self.from_chain[:, None])[:, None, :]
        return np.asarray(torques.reshape(*torques.shape[:-1], 3, len(frames)) * moved)

    @cached_property
    def chain(self) -> SpatialChain:
        """The chain, as far as the sensors see it yield."""
        layout = self.layout
        return SpatialChain.of(layout.finger.segments, layout.finger.segment_length, layout.ways)

    @cached_property
    def only_bends(self) -> bool:
        """Whether the finger stays in its plane, as far as the sensors see."""
        return self.layout.ways == ("bending",)

    @cached_property
    def from_chain(self) -> NDArray[np.int_]:
        """Joints of the chain in the order way after way, (D,)."""
        return np.argsort(self.in_chain)

    @cached_property
    def in_chain(self) -> NDArray[np.int_]:
        return self.chain.position_indices(self.layout.ways)

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
        base = self.uncertainty.load_pressure * finger.pressure_gain.max()  # N m, torque of a usual load
        along = np.repeat(lengths / 2, 2) * 3 / finger.length**3
        variances = base**2 * np.append((1 - TIP_SHARE) * along, TIP_SHARE / finger.length**2)
        places = np.append((lengths[:, None] * (0.5 + _GAUSS)).ravel(), lengths[-1])
        return _Points(np.append(np.repeat(self.links, 2), self.links[-1]), _local(0.0 * places, places), variances)

    @cached_property
    def _beyond(self) -> Array:
        """Variances of the forces, (N, K) N^2; 0 where the joints of a segment do not move the place."""
        return (self._forces.frames > self.links[:-1, None]) * self._forces.weights

    @cached_property
    def _masses(self) -> tuple[_Points, Array]:
        """Middles of the links, and the masses that each joint carries, (D, N + 1) kg."""
        links = self.layout.finger.links
        x, z = links.center
        return _Points(self.links, _local(x, z), links.mass), (self.links > self.from_chain[:, None]) * links.mass

    @cached_property
    def _forces_in_plane(self) -> PointsInPlane:
        return self._forces.in_plane(self.layout.finger.link_ends)

    @cached_property
    def _masses_in_plane(self) -> PointsInPlane:
        return self._masses[0].in_plane(self.layout.finger.link_ends)

    def prior(self, at: BentFinger, q: Array, driving: Array, away: "Away | None" = None) -> Array:
        """The covariance P of the joints before the sensors are read, (..., D, D), about the posture of `q`."""
        return self.of_load(at, q) + self.of_model(q, driving, away)

    def of_model(self, q: Array, driving: Array, away: "Away | None" = None) -> Array:
        """The part of P that is due to deviations of finger and pressure from the nominal model, (..., D, D)."""
        compliance = self.compliance(q)
        of_driving = (compliance * driving)[..., None, :] * self.bend_changes
        covariance = np.swapaxes(of_driving, -1, -2) @ of_driving
        covariance = covariance + (self._else_if_linear if self._is_linear else self._else(compliance))
        if away is not None:
            covariance = covariance + outer(compliance * (away.pressure[..., None] * self.pressure_gain))
        return covariance

    def away(self, readings: Array, driving: Array, gravity: Array) -> "Away | None":
        """How much less is known away from the states in which the finger was calibrated; None: it was not."""
        states = self.layout.calibrated
        if states is None:
            return None
        measured = self.layout.measured(readings)
        return self.away_by(states, shared(CalibratedStates.distances, states, measured, driving, gravity))

    def away_by(self, states: CalibratedStates, distances: StateDistances) -> "Away":
        """How much less is known at distances from the states."""
        of_drive, of_sections = states.errors(distances)
        return Away(of_drive / self._strain_per_pressure, of_sections / np.abs(self.layout.sensitivity).max(axis=0))

    def of_scale(self, q: Array) -> Array | float:
        """Covariance of the scale of finger and sensors, at angles `q`, (..., D, D); 0 if not calibrated.

        The scale is a common one, and one that changes linearly along the finger; neither changes what is read.
        """
        states = self.layout.calibrated
        if states is None:
            return 0.0
        finger = self.layout.finger
        along = np.tile(2 * finger.joint_arc_lengths / finger.length - 1, len(self.layout.ways))
        return outer(states.bend_std * q) + outer(states.variation_std * along * q)

    @cached_property
    def _strain_per_pressure(self) -> float:
        """Change of the reading that the pressure moves most, at the straight finger, 1/Pa."""
        return float(np.abs(self.layout.jacobian @ (self._compliance_if_linear * self.pressure_gain)).max())

    def compliance(self, q: Array) -> Array:
        """Compliance of the joints, rad/(N m), and m/N where they slide, (D,) or, under an elastic law, (..., D)."""
        if self._is_linear:
            return self._compliance_if_linear
        finger = self.layout.finger
        compliance = np.broadcast_to(self._compliance_if_linear, q.shape).copy()
        compliance[..., : finger.segments] = 1 / finger.joint_law.slope(q[..., : finger.segments])
        return compliance

    def free(self, torque: Array) -> Array:
        """Joint positions at which the elastic torque is `torque`, (..., D)."""
        if self._is_linear:
            return torque / self.stiffness
        finger, q = self.layout.finger, torque / self.stiffness
        q[..., : finger.segments] = finger.angle(torque[..., : finger.segments])
        return np.asarray(q)

    def unloaded(self, q: Array, torque: Array) -> Array:
        """Joint positions under a known torque alone, linearized about those of a bent finger, `q`, (..., D)."""
        if self._is_linear:
            return self.free(torque)
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
        return np.tile(stds[:, None] * polynomials.T, len(self.layout.ways))

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
        """Covariance of further deviations from the nominal joints, (D, D); where they slide, as far over a segment."""
        finger, angle = self.layout.finger, self.uncertainty.angle
        each = [angle * finger.segment_length if way in SLIDES else angle for way in self.layout.ways]
        return np.diag(np.repeat(each, finger.segments) ** 2)

    def _else(self, compliance: Array) -> Array:
        return outer(compliance * (self.uncertainty.pressure * self.pressure_gain)) + self.deviations

    @cached_property
    def _else_if_linear(self) -> Array:
        return self._else(self._compliance_if_linear)

    @cached_property
    def _is_linear(self) -> bool:
        return self.layout.finger.elastic_law is None

    @cached_property
    def stiffness(self) -> Array:
        """Stiffness of every joint, N m/rad, and N/m where it slides, (D,)."""
        return np.concatenate([self.layout.finger.stiffnesses[way] for way in self.layout.ways])

    @cached_property
    def _compliance_if_linear(self) -> Array:
        return np.asarray(1 / self.stiffness)


def _local(x: Array, z: Array) -> Array:
    """(p, 1) of points of the bending plane, (K, 4, 1)."""
    return np.stack([x, 0.0 * z, z, np.ones(z.shape)], axis=-1)[..., None]


def _strongest(covariance: Array) -> tuple[Array, Array]:
    """The largest eigenvalues, and their vectors in columns."""
    values, vectors = np.linalg.eigh(covariance)
    return values[::-1][:_MODES], vectors[:, ::-1][:, :_MODES]


def outer(vector: Array) -> Array:
    """Outer product, (..., N) -> (..., N, N)."""
    return vector[..., :, None] * vector[..., None, :]
