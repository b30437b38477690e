"""The contact of a finger: the force as a vector, its place along and around the finger, and how well they are known.

In most grasps a finger touches one object. Driving torque and weight leave the values r = z - g(q) - A (q_0 - q) that
are read unexplained: q is a shape close to the true one, first that of `gaussian`, then that under the force found so;
A are the slopes of the values there, and q_0 the joints without a load. If noise and uncertainty explain them, there is
no contact. A load on a link, with the wrench f = (moment about the link's origin, force) in its frame, changes them by

    G f ,   G = A C J^T ,

with J the motion of the link and C the compliance of the joints. All that lies beyond a joint turns it alike, so that
the sums of  (A C) (screw of the joint)  from the base to a link give its G.

`contact_cells` divides the surface into cells. In a cell a force of 1 N presses inward; friction in the directions of
the surface, the place along and across the cell, and the link on which it acts, change its wrench linearly, each by an
independent standard normal variable. `force_posterior` says what follows for the size F of the force. These variables
are then Gaussian again,

    z ~ N((I + U U^T)^-1 U (r - F c), (I + U U^T)^-1) ,   all whitened, U = F times the spreads,

which gives friction, hence the force as a vector, and the place within the cell. The contact that is reported is that
of the most probable cell. Its standard deviations are root mean square distances of the posterior from it: over all
cells for force and place, over those that hold nearly all of the posterior for the vector.

If a single force leaves more than noise, and enough values are read, several forces on the side that it presses explain
them: forces f_m >= 0 in its smooth cells, M f , are found by non-negative least squares (Lawson and Hanson 1974, ch.
23), with a little weight on their squares so that there is one answer. Few of them are not zero: a contact only pushes,
and that alone makes it sparse (Slawski and Hein 2013, doi 10.1214/13-EJS868). How uncertain their sum and centre are
follows from those that are not zero and the places beside them, with friction along the finger at each.

Force and place of a single contact from a curved shape: Rucker and Webster (2011, doi 10.1109/IROS.2011.6094526) for
continuum robots; from sparse readings: arXiv 2109.12469.

A force of 0.2 N that presses on the inner side, 90 mm from the base, of a finger without pressure:

    >>> import numpy as np
    >>> import soft_gripper as sg
    >>> finger = sg.make_station(sg.load_scenario("free_bending")).fingers[0].finger
    >>> layout = sg.sensors.SensorLayout(finger, sections=4)
    >>> q = finger.angle(-0.2 * (0.09 - finger.joint_arc_lengths).clip(0))
    >>> contact = sg.estimators.ContactShape(layout)(layout.read(q), np.zeros_like(q), np.zeros(3)).contact
    >>> print(f"{contact.force:.2f} +- {contact.force_std:.2f} N, {1e3 * contact.arc_length:.0f} mm from the base")
    0.20 +- 0.02 N, 90 mm from the base

Leading axes are free; S values, D joint positions, way after way, L links, P places, C cells, T tangents: two, or the
one in its plane of a finger that only bends.

Symbols, beside those of `gaussian`: r values left unexplained; f wrench on a link; J motion of the link by the joints;
C compliance of the joints, rad/(N m); c values changed by a force of 1 N in a cell, F its size, N; U changes of F c by
friction and place, one standard deviation each; M values changed by forces in the smooth cells, f_m their sizes, N.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import Later, in_parts, shared
from soft_gripper.estimators.contact_cells import SMOOTH_FRICTION, SurfaceCells
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.force_posterior import (
    Believed,
    Cells,
    ContactPosterior,
    FittedCells,
    Forces,
    believed,
    contact_posterior,
    fitted,
    weighed,
    whitening,
)
from soft_gripper.estimators.free_motion import AT_REST, STILL, FreeMotion, Lag, may_exceed
from soft_gripper.estimators.gaussian import GaussianShape, gain_of
from soft_gripper.estimators.mechanics import BentFinger, Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import Zeroing
from soft_gripper.fingers.spatial_chain import Posture, vector_product
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel

if TYPE_CHECKING:  # imported where it is made
    from scipy.sparse import csr_array

_CHANCE = 1e-3  # probability that noise alone exceeds the noise level
_HEAVIEST = 96  # cells, over which means are taken
_TINY = 1e-30
_SIDE = math.sqrt(3)  # standard deviations, from the middle of a cell to its sides
_PLACE_INFORMATION = 1e-3  # of the place within the most probable cell, information before anything is read
_TURNS = 2  # by which the most probable force and what is uncertain under it are found in turn
# Friction at the limit of the cone, and the place at the sides of a face, in standard deviations of the spreads.
_CORNERS = np.array(
    [[i, j, 0, k] for i, j in ((-1, 0), (1, 0), (0, -1), (0, 1)) for k in (-math.sqrt(3), math.sqrt(3))]
)


class Unexplained(NamedTuple):
    """Values that driving torque and weight do not explain, and the shape about which they are linearized."""

    q: Array  # (..., D)
    at: BentFinger  # at q
    slopes: Array  # A, (..., S, D)
    read: Array  # (...) number of values that are read
    residual: Array  # r, (..., S)
    covariance: Array  # (..., S, S), of noise, model and motion
    moving: Array = STILL  # (...) 1 where a free finger in motion may have them, else 0


class HeaviestCells(NamedTuple):
    """Forces in the K cells that hold nearly all of the posterior, the most probable one first."""

    cells: NDArray[np.int_]  # (..., K)
    weights: Array  # (..., K), 1 in all
    force: Array  # (..., K) N
    z: Array  # (..., K, D), spreads of the cell's response, in standard deviations
    covariance: Array  # (..., K, D, D), of these
    local: Array  # (..., 3) N, the force in the first cell in the frame of its link
    vectors: Array  # (..., K, 2 + T, 3) N in B: the force, and what friction and size add to it, one deviation each
    arc_length: Array  # (..., K) m, where it presses
    points: Array  # (..., K, 3) m in B, there on the axis of the finger


class Explained(NamedTuple):
    """Values explained by one force: what it is in every cell, and how probable."""

    left: Unexplained
    found: FittedCells
    posterior: Believed
    heaviest: Later[HeaviestCells]


class _Several(NamedTuple):
    """Several forces on a side of one sample."""

    fields: Mapping[str, Array | float]  # of the contact that they are together
    torque: Array  # (D) at the joints
    chi_squared: float  # of what they do not explain


@dataclass(frozen=True)
class SurfaceContact:
    """The contact on the surface of a finger that explains what is read."""

    mechanics: Mechanics

    def explain(self, left: Unexplained) -> Explained:
        """The forces in all cells."""
        W = whitening(left.covariance)
        cells, r = self.cells(left.q, left.at, W @ left.slopes), (W @ left.residual[..., None])[..., 0]
        refined = not self.mechanics.only_bends  # there, friction has cells of its own
        found = fitted(r, cells, self._possible.largest, refined)
        posterior = believed(found, left.read, self._possible)
        return Explained(left, found, posterior, Later(lambda: self._heaviest(left, found, posterior)))

    def stated(self, explained: Explained) -> tuple[ContactForce, Array]:
        """The contact, and its torques at the joints: none where noise explains the values, or too few are read.

        One force, or several on the side that it presses if it leaves more than noise and more is read than it takes.
        """
        left, found, posterior, _ = explained
        contact, torque, side = self.best(explained)
        noise = _most_of_noise(left.read - self.fewest)
        many = (left.read > self.fewest) & (found.chi_squared.min(axis=-1) > noise)
        if many.any():
            contact, torque = self._put_several(many, side, contact, torque, explained)
        free = (found.r**2).sum(axis=-1) < _most_of_noise(left.read)
        unknown = (left.read < self.fewest) | (free & (left.moving > 0))
        contact = contact._replace(force_std=np.where(free, self._of_force_on_tip(posterior), contact.force_std))
        return _stated(contact, free, unknown), np.where((free | unknown)[..., None], 0.0, torque)

    def _of_force_on_tip(self, posterior: Believed) -> Array:
        """Standard deviation of a force on the tip, N, (...), as it may be overlooked where nothing is found."""
        surface = self.surface
        smooth = np.flatnonzero(surface.on_face & ~surface.rough & (surface.place == surface.place.max()))
        return np.asarray(posterior.std[..., smooth].max(axis=-1))

    def posterior(self, explained: Explained) -> ContactPosterior:
        """Posterior of the contact."""
        left, found, posterior, _ = explained
        length = self.mechanics.layout.finger.length
        nearest = self.mechanics.uncertainty.nearest_contact * length
        heaviest = explained.heaviest
        transverse = Later(lambda: weighed(*transverse_forces(heaviest.value), heaviest.value.weights))
        return contact_posterior(
            found,
            posterior,
            transverse,
            left.read,
            length,
            self._possible,
            nearest,
            left.moving,
            self._outermost(found.cells),
        )

    @property
    def fewest(self) -> int:
        """How many values a force is estimated from, at least: as many as it has unknowns, its face among them."""
        return 2 if self.mechanics.only_bends else 3

    def cells(self, q: Array, bent: BentFinger, slopes: Array) -> Cells:
        """The changes of the values by forces in all cells, of a finger that is bent by `q`."""
        surface, at, links = self.surface, bent.chain, self.mechanics.links
        by_torque = (slopes * self.mechanics.compliance(q)[..., None, :])[..., self.mechanics.in_chain]
        by_joint = np.swapaxes(by_torque, -1, -2)[..., :, None, :] * at.screws[..., None]  # (..., D, 6, S)
        before = np.concatenate([np.zeros_like(by_joint[..., :1, :, :]), by_joint.cumsum(axis=-3)], axis=-3)
        moments, forces = np.split(before[..., links, :, :], 2, axis=-2)
        turn, origins = np.swapaxes(at.rotations[..., links, :, :], -1, -2), at.origins[..., links, :]
        about = vector_product(np.swapaxes(moments, -1, -2), origins[..., None, :])  # forces act at the links' origins
        forces = forces + np.swapaxes(about, -1, -2)
        known = [np.concatenate([turn @ moments, turn @ forces], axis=-2)]  # (..., L, 6, S)
        if self.mechanics.only_bends:
            link, joint, _ = surface.pairs
            known.append(turn[..., link, :, :] @ np.diff(moments, axis=-3)[..., joint, :, :])  # (..., X, 3, S)
        known = [each.reshape(*each.shape[:-3], -1, each.shape[-1]) for each in known]
        changes = _product(self._by_wrench, np.concatenate(known, axis=-2), len(surface.place))  # (1 + D, S, ..., C)
        response, spreads = np.moveaxis(changes[0], 0, -1), np.moveaxis(changes[1:], (0, 1), (-2, -1))
        return Cells(response, spreads, surface.place, surface.side, surface.prior, surface.angle)

    @cached_property
    def _by_wrench(self) -> "csr_array":
        """The changes by forces in all cells as one matrix, ((1 + D) C, 6 L).

        It is of what wrenches on the links do, and, if the finger only bends, moments at the joint and on the link of
        each pair, (..., 3 X) more.
        """
        from scipy.sparse import block_diag

        surface = self.surface
        wrenches = np.swapaxes(surface.wrenches, 0, 1)
        rows, links = wrenches.reshape(-1, 6), np.tile(surface.link, len(wrenches))
        blocks = [_sparse(rows, links, len(self.mechanics.links))]
        if self.mechanics.only_bends:
            link, _, number = surface.pairs
            blocks.append(_sparse(surface.straddled, number, len(link)))
        return block_diag(blocks, "csr")

    def best(self, explained: Explained) -> tuple[ContactForce, Array, NDArray[np.int_]]:
        """The most probable contact, its torques at the joints, (..., D), and the side that it presses, (...)."""
        surface, heaviest = self.surface, explained.heaviest.value
        left, _, posterior, _ = explained
        cells, force, z, of_z = heaviest.cells, heaviest.force, heaviest.z, heaviest.covariance
        vector, of_vector = _about_best(heaviest.weights, heaviest.vectors)
        sizes, deviations = transverse_forces(heaviest)
        T, best = surface.tangents, cells[..., 0]
        place = heaviest.arc_length[..., 0]
        across = -heaviest.local[..., 0]
        across_std, place_std = self._deviations(posterior, across, place, of_z[..., 0, T, T])
        contact = ContactForce(
            force=across,
            arc_length=place,
            force_std=across_std,
            arc_length_std=place_std,
            vector=vector,
            vector_covariance=of_vector,
            direction_std=_direction_std(vector, of_vector),
            side=surface.angle[cells[..., 0]],
            transverse_force=sizes[..., 0],
            transverse_force_std=np.sqrt(
                (heaviest.weights * ((sizes - sizes[..., :1]) ** 2 + deviations**2)).sum(axis=-1)
            ),
        )
        wrenches = surface.wrenches[cells[..., 0]]
        wrench = wrenches[..., 0, :] + (z[..., :1, : 2 * T] @ wrenches[..., 1:, :])[..., 0, :]
        torque = self._torques(left.at.chain, surface.link[cells[..., :1]], force[..., :1] * wrench)
        if self.mechanics.only_bends:
            torque = torque + self._straddled(left.at.chain, best, force[..., :1] * z[..., 0, -1:])
        return contact, torque, surface.side[cells[..., 0]]

    def _heaviest(self, left: Unexplained, found: FittedCells, posterior: Believed) -> HeaviestCells:
        """The forces in the cells that hold nearly all of the posterior."""
        surface, most = self.surface, self._possible.largest
        weights, cells = _heaviest(posterior)
        force = np.minimum(_chosen(posterior.mean, cells), most)
        force[..., 0] = np.clip(_chosen(posterior.force, cells[..., :1])[..., 0], 0, most)
        response, spreads = _chosen(found.cells.response, cells), _chosen(found.cells.spreads, cells)
        z, of_z, turn = _within(found.r, force, response, spreads)
        if self.mechanics.only_bends:  # in space, friction along the finger would be taken for the place
            of_best = force[..., 0], response[..., 0, :], spreads[..., 0, :, :]
            force[..., 0], z[..., 0, :] = self._fitted_best(found.r, *of_best)
        R = _chosen(left.at.chain.rotations, self.mechanics.links[surface.link[cells]])
        local = _forces(surface.directions[cells], force, _chosen(posterior.std, cells), z, of_z, turn)
        arc_length = surface.arc_length[cells] + surface.extent[cells] * z[..., surface.tangents]
        arc_length = arc_length.clip(0, self.mechanics.layout.finger.length)
        points = self._on_axis(left.at.chain.frames, arc_length)
        vectors = local @ np.swapaxes(R, -1, -2)
        return HeaviestCells(cells, weights, force, z, of_z, local[..., 0, 0, :], vectors, arc_length, points)

    def _on_axis(self, frames: Array, arc_length: Array) -> Array:
        """Points on the axis of the finger, (..., K, 3) m in B, at arc lengths, (..., K); `frames` are the chain's."""
        finger = self.mechanics.layout.finger
        link = np.searchsorted(finger.joint_arc_lengths, arc_length)
        of_link = _chosen(frames, self.mechanics.links[link])
        height = arc_length - finger.link_ends[:-1][link]
        return np.asarray(of_link[..., :3, 3] + height[..., None] * of_link[..., :3, 2])

    def _fitted_best(self, r: Array, force: Array, response: Array, spreads: Array) -> tuple[Array, Array]:
        """Force, (...) N, and spreads, (..., D), of the most probable cell, whose place is any within the cell."""
        usual, most, at = self._possible.usual, self._possible.largest, self.surface.tangents
        moved, others = spreads[..., at, :], np.delete(spreads, at, axis=-2)
        for _ in range(_TURNS):  # what is uncertain in the cell beside the place follows the force
            U = force[..., None, None] * others
            weights = np.linalg.inv(np.swapaxes(U, -1, -2) @ U + np.eye(r.shape[-1]))
            both = np.stack([response, moved], axis=-2)  # r is nearly linear in the force and the force times the place
            information = both @ weights @ np.swapaxes(both, -1, -2)
            information[..., 0, 0] += usual**-2
            information[..., 1, 1] += _PLACE_INFORMATION / np.maximum(force, _TINY) ** 2
            size, product = np.moveaxis(np.linalg.solve(information, both @ weights @ r[..., None])[..., 0], -1, 0)
            place = (product / np.where(size == 0, _TINY, size)).clip(-_SIDE, _SIDE)
            c = response + place[..., None] * moved
            weighted = (weights @ c[..., None])[..., 0]
            force = ((weighted * r).sum(axis=-1) / ((weighted * c).sum(axis=-1) + usual**-2)).clip(0, most)
        left = r - force[..., None] * c
        z = (U @ weights @ left[..., None])[..., 0]
        return force, np.insert(z, at, place, axis=-1)

    def _deviations(self, posterior: Believed, force: Array, place: Array, within: Array) -> tuple[Array, Array]:
        """Root mean square distances of the posterior from a normal force, N, and a location, m, (...).

        `within` is the variance of the place within the most probable cell, as a share of that before anything is read.
        """
        surface, force, place = self.surface, force[..., None], place[..., None]
        across = -surface.directions[:, 0, 0]
        squares = across**2 * posterior.square - 2 * across * posterior.mean * force + force**2
        places = (surface.arc_length - place) ** 2 + surface.extent**2 * within[..., None]
        of_force, of_place = ((posterior.weight * each).sum(axis=-1) for each in (squares, places))
        return np.sqrt(np.maximum(of_force, 0)), np.sqrt(of_place)

    def _put_several(
        self,
        chosen: NDArray[np.bool_],
        side: NDArray[np.int_],
        contact: ContactForce,
        torque: Array,
        explained: Explained,
    ) -> tuple[ContactForce, Array]:
        """Contact and torque of K samples; of the chosen ones those of several forces, if these explain more than one.

        One force rubs along the finger and across it as it likes, which several may do less.
        """
        contact, torque = ContactForce(*(np.array(values) for values in contact)), torque.copy()
        for k in np.flatnonzero(chosen & np.isin(side, self.surface.side[self._smooth_places])):
            several = self._several(int(k), int(side[k]), explained)
            if several.chi_squared <= explained.found.chi_squared[k].min():
                torque[k] = several.torque
                for name, value in several.fields.items():
                    getattr(contact, name)[k] = value
        return contact, torque

    def _several(self, k: int, side: int, explained: Explained) -> _Several:
        """The forces on a side that explain sample k best."""
        from scipy.optimize import nnls

        left, found, _, _ = explained
        surface, assumed = self.surface, self.mechanics.uncertainty
        smooth = np.flatnonzero(self._smooth_places & (surface.side == side))
        responses, usual, tangents = found.cells.response[k, smooth].T, self._possible.usual, surface.tangents
        rows = np.vstack([responses, np.eye(len(smooth)) / usual])
        forces, _ = nnls(rows, np.append(found.r[k], np.zeros(len(smooth))))
        of_friction = assumed.friction / math.sqrt(3) / SMOOTH_FRICTION * forces
        rubbing = (of_friction[:, None, None] * found.cells.spreads[k, smooth, :tangents]).reshape(-1, len(responses))
        uncertain = np.eye(len(responses)) + rubbing.T @ rubbing
        rest = found.r[k] - responses @ forces
        after = _covariance_of_several(responses, uncertain, forces, usual)
        total, s = forces.sum(), surface.arc_length[smooth]
        pressing = total if total > 0 else np.nan
        center = forces @ s / pressing
        directions = surface.directions[smooth, 0]
        frames = self.mechanics.links[surface.link[smooth]]
        in_base = (left.at.chain.rotations[k, frames] @ directions[..., None])[..., 0]
        at = Posture(*(np.broadcast_to(part[k], (len(smooth), *part.shape[1:])) for part in left.at.chain))
        wrenches = forces[:, None] * surface.wrenches[smooth, 0]
        vector, of_vector = forces @ in_base, in_base.T @ after @ in_base
        (point,) = self._on_axis(left.at.chain.frames[k], np.array([center if total > 0 else 0.0]))
        across, transverse = _transverse(vector, point)
        fields = {
            "force": float(-forces @ directions[:, 0]),
            "arc_length": float(center),
            "force_std": float(_std_of_sum(after, directions[:, 0])),
            "arc_length_std": float(_std_of_sum(after, (s - center) / pressing)),
            "vector": vector,
            "vector_covariance": of_vector,
            "transverse_force": transverse,
            "transverse_force_std": np.sqrt(across @ of_vector @ across),
        }
        torque = self._torques(at, surface.link[smooth][:, None], wrenches).sum(axis=0)
        return _Several(fields, torque, float(rest @ np.linalg.solve(uncertain, rest)))

    @cached_property
    def _smooth_places(self) -> NDArray[np.bool_]:
        """Which cells are smooth, on faces, and where a contact may be, (C)."""
        surface, length = self.surface, self.mechanics.layout.finger.length
        nearest = self.mechanics.uncertainty.nearest_contact * length
        return surface.on_face & ~surface.rough & (nearest <= surface.arc_length) & (surface.arc_length < length)

    def _torques(self, at: Posture, link: NDArray[np.int_], wrench: Array) -> Array:
        """At the joints, (..., D), of a wrench in the frame of a link, (..., 6) and (..., 1)."""
        frames = self.mechanics.links[link]
        R, origins = _chosen(at.rotations, frames)[..., 0, :, :], _chosen(at.origins, frames)[..., 0, :]
        moment, force = ((R @ part[..., None])[..., 0] for part in (wrench[..., :3], wrench[..., 3:]))
        in_base = np.concatenate([moment + vector_product(origins, force), force], axis=-1)
        moved = frames > np.arange(at.screws.shape[-2])
        return np.asarray((moved * (at.screws @ in_base[..., None])[..., 0])[..., self.mechanics.from_chain])

    def _outermost(self, cells: Cells) -> Cells:
        """Cells of each of several forces, with friction at the cone: what others do, these do together.

        If the finger only bends, these are those of the most friction in every place; else they are on the middles and
        the sides of faces.
        """
        surface = self.surface
        if self.mechanics.only_bends:
            rough = np.flatnonzero(surface.rough)
            begins = np.diff(surface.arc_length[rough], prepend=np.nan, append=np.nan) != 0
            chosen = rough[begins[:-1] | begins[1:]]
            response = cells.response[..., chosen, :]
        else:
            chosen = np.flatnonzero(surface.rough & surface.on_face & (cells.place % 2 == 1))
            response = cells.response[..., chosen, None, :] + _CORNERS @ cells.spreads[..., chosen, :, :]
            response = response.reshape(*response.shape[:-3], -1, response.shape[-1])
            chosen = np.repeat(chosen, len(_CORNERS))
        others = cells.place[chosen], cells.side[chosen], cells.prior[chosen], cells.angle[chosen]
        return Cells(response, cells.spreads, *others)

    def _straddled(self, at: Posture, cell: NDArray[np.int_], force: Array) -> Array:
        """At the joints, (..., D), of a contact that lies on two links: of forces, (..., 1), on the lever of a cell."""
        surface = self.surface
        R = np.take_along_axis(at.rotations, self.mechanics.links[surface.link[cell]][..., None, None, None], axis=-3)
        moment = (R[..., 0, :, :] @ (force * surface.straddled[cell])[..., None])[..., 0]
        beside = self.mechanics.chain.segments == surface.nearest[cell][..., None]
        return np.asarray((beside * (at.screws[..., :3] @ moment[..., None])[..., 0])[..., self.mechanics.from_chain])

    @property
    def _possible(self) -> Forces:
        return Forces(self.mechanics.usual_force, self.mechanics.uncertainty.largest_force)

    @cached_property
    def surface(self) -> SurfaceCells:
        """The cells of the finger."""
        layout = self.mechanics.layout
        return SurfaceCells.of(layout.finger, layout.ways, self.mechanics.uncertainty.friction)


@dataclass(frozen=True)
class ContactShape:
    """The estimator `contact` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between the samples of a finger that moves

    def __call__(
        self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST, std: Array | None = None
    ) -> ShapeEstimate:
        """The joint positions, their covariance and the contact; see ShapeFunction, and for `std` GaussianShape.

        The contact is NaN where too little is read (`SurfaceContact.fewest`), and where nothing is found of a finger
        that moves; `lag` is that of a free finger in motion, (..., D) each.
        """
        found: ShapeEstimate = self._in_parts(self._shape, readings, driving, gravity, lag, std)
        return found

    def posterior(
        self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST, std: Array | None = None
    ) -> ContactPosterior:
        """Posterior of one contact, with whatever trades off against it; see `__call__`."""
        found: ContactPosterior = self._in_parts(self._posterior, readings, driving, gravity, lag, std)
        return found

    @cached_property
    def motion(self) -> FreeMotion:
        """The motion of the finger while nothing touches it."""
        return FreeMotion(self._gaussian.mechanics, self.period)

    @property
    def zeroing(self) -> Zeroing | None:
        """The block that follows the zeros of the sensors; see GaussianShape."""
        return self._gaussian.zeroing

    def _in_parts(
        self, function: Any, readings: Array, driving: Array, gravity: Array, lag: Lag, std: Array | None
    ) -> Any:
        leading = readings.shape[:-1]
        others = driving, gravity, np.full(1, self.uncertainty.any_reading()) if std is None else std, *lag
        return in_parts(function, readings, *(np.broadcast_to(each, (*leading, each.shape[-1])) for each in others))

    def _shape(self, readings: Array, driving: Array, gravity: Array, std: Array, *lag: Array) -> ShapeEstimate:
        shape = shared(GaussianShape.__call__, self._gaussian, readings, driving, gravity, std)
        explained, free = shared(ContactShape._explained, self, shape.q, readings, driving, gravity, std, *lag)
        contact, torque = self.contact.stated(explained)
        loaded = self._loaded(explained.left, free, torque, readings, driving, gravity, std)
        q = np.where(torque.any(axis=-1, keepdims=True), loaded, shape.q)
        return ShapeEstimate(q, shape.covariance, contact)

    def _posterior(self, readings: Array, driving: Array, gravity: Array, std: Array, *lag: Array) -> ContactPosterior:
        shape = shared(GaussianShape.__call__, self._gaussian, readings, driving, gravity, std)
        explained, _ = shared(ContactShape._explained, self, shape.q, readings, driving, gravity, std, *lag)
        return self.contact.posterior(explained)

    def _explained(
        self,
        q: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        std: Array | None = None,
        damping: Array = AT_REST.damping,
        inertia: Array = AT_REST.inertia,
    ) -> tuple[Explained, Array]:
        """The forces in all cells, linearized about the finger under the likeliest of those about `q`; and q_0."""
        lag = Lag(damping, inertia)
        left, free = self._unexplained(q, readings, driving, gravity, lag, std)
        explained = self.contact.explain(left)
        for _ in range(self._passes - 1):
            q = self._loaded(left, free, self.contact.best(explained)[1], readings, driving, gravity, std)
            left, free = self._unexplained(q, readings, driving, gravity, lag, std)
            explained = self.contact.explain(left)
        return explained, free

    @cached_property
    def _passes(self) -> int:
        """How often the load is linearized; where it changes nothing but the posture, the shape of `gaussian` does."""
        return 1 if self.contact.mechanics.only_bends and self.layout.finger.elastic_law is None else 2

    def _loaded(
        self,
        left: Unexplained,
        free: Array,
        torque: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        std: Array | None,
    ) -> Array:
        """Joint positions under torques of a contact, (..., D); what they do not explain is shared as by `gaussian`."""
        mechanics, away = self._gaussian.mechanics, self._gaussian.away(readings, driving, gravity)
        variance = self._gaussian.read(readings, std, away).variance
        loaded = mechanics.compliance(left.q) * torque
        remaining = left.residual - (left.slopes @ loaded[..., None])[..., 0]
        gain, _ = gain_of(left.slopes, mechanics.prior(left.at, left.q, driving, away), variance)
        return np.asarray(free + loaded + (gain @ remaining[..., None])[..., 0])

    def _unexplained(
        self,
        q: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        lag: Lag = AT_REST,
        std: Array | None = None,
    ) -> tuple[Unexplained, Array]:
        """Linearized about joint positions `q`, and the joints without a load, q_0, (..., D).

        The stiffness may be as wrong as the bend per driving torque, and then a share of every bend is.
        """
        mechanics, away = self._gaussian.mechanics, self._gaussian.away(readings, driving, gravity)
        values, variance = self._gaussian.read(readings, std, away)
        at, (predicted, A) = mechanics.posture(q), self.layout.values_at(q)
        free = mechanics.unloaded(q, driving + mechanics.weight(at, gravity))
        residual = values - predicted - (A @ (free - q)[..., None])[..., 0]
        of_stiffness = A @ np.swapaxes(mechanics.bend_changes * q[..., None, :], -1, -2)
        of_model = A @ mechanics.of_model(q, driving, away) @ np.swapaxes(A, -1, -2)
        at_rest = of_model + of_stiffness @ np.swapaxes(of_stiffness, -1, -2)
        at_rest = at_rest + variance[..., None] * np.eye(A.shape[-2])
        read, of_motion = (variance < UNKNOWN / 2).sum(axis=-1, dtype=float), lag.seen_by(A)
        moving = may_exceed(of_motion, at_rest, _most_of_noise(read))
        return Unexplained(q, at, A, read, residual, at_rest + of_motion, moving), free

    @cached_property
    def contact(self) -> SurfaceContact:
        """Contacts that explain readings."""
        return SurfaceContact(self._gaussian.mechanics)

    @cached_property
    def _gaussian(self) -> GaussianShape:
        return GaussianShape(self.layout, self.uncertainty, self.period)


def _most_of_noise(read: Array) -> Array:
    """Misfit threshold for noise, (...), by the number of values that are read."""
    from scipy.special import chdtri

    return np.asarray(chdtri(np.maximum(read, 1), _CHANCE))


def _heaviest(posterior: Believed) -> tuple[Array, NDArray[np.int_]]:
    """Weights that sum to 1 and numbers, (..., K), of the most probable cell, which is the first, and the heaviest."""
    rank = posterior.weight.copy()
    np.put_along_axis(rank, posterior.best[..., None], np.inf, axis=-1)
    cells = np.argsort(-rank, axis=-1)[..., :_HEAVIEST]
    weights = np.take_along_axis(posterior.weight, cells, axis=-1)
    return weights / weights.sum(axis=-1, keepdims=True), cells


def _chosen(values: Array, numbers: NDArray[np.int_]) -> Array:
    """Values chosen for each sample, (..., C, ...), by their numbers, (..., K)."""
    samples = np.arange(numbers.size // numbers.shape[-1]).reshape(*numbers.shape[:-1], 1)
    flat = values.reshape(-1, *values.shape[numbers.ndim :])
    return np.asarray(flat[numbers + values.shape[numbers.ndim - 1] * samples])


def _within(r: Array, force: Array, response: Array, spreads: Array) -> tuple[Array, Array, Array]:
    """Spreads of a cell's response, (..., K, D), in standard deviations, given the readings and the force.

    Also their covariance, and their change with the force: what a larger one bends more, they take back.
    """
    # (S, ..., K) and (D, S, ..., K): sums over short first axes are quick
    r, c = np.moveaxis(r, -1, 0)[..., None], np.moveaxis(response, -1, 0)
    U = force * np.moveaxis(spreads, (-2, -1), (0, 1))
    products, identity = np.einsum("ds...,es...->de...", U, U), np.eye(len(U))
    covariance = _inverse(products + identity.reshape(*identity.shape, *[1] * force.ndim))
    seen = (np.einsum("ds...,s...->d...", U, vectors) for vectors in (r - force * c, -c))
    z, turn = (np.moveaxis(np.einsum("de...,e...->d...", covariance, vectors), 0, -1) for vectors in seen)
    return z, np.moveaxis(covariance, (0, 1), (-2, -1)), turn


def _inverse(matrices: Array) -> Array:
    """Inverses of small positive definite matrices, (D, D, ...), by Gauss and Jordan."""
    found = matrices.copy()
    for k in range(len(found)):
        pivot = 1 / found[k, k]
        row, column = found[k] * pivot, found[:, k].copy()
        found -= column[:, None] * row
        found[k], found[:, k] = row, -column * pivot
        found[k, k] = pivot
    return found


def _forces(directions: Array, force: Array, std: Array, z: Array, of_z: Array, turn: Array) -> Array:
    """Forces in the frames of their links and T + 1 independent deviations, (..., K, 2 + T, 3) N.

    See `_within` for z and its change with the force, `SurfaceCells` for the directions.
    """
    T = directions.shape[-2] - 1
    unit, sizes = directions[..., :1, :] + z[..., None, :T] @ directions[..., 1:, :], force[..., None, None]
    rubbing = np.swapaxes(np.linalg.cholesky(of_z[..., :T, :T]), -1, -2) @ directions[..., 1:, :]
    by_size = unit + sizes * turn[..., None, :T] @ directions[..., 1:, :]
    return np.concatenate([sizes * unit, sizes * rubbing, std[..., None, None] * by_size], axis=-2)


def transverse_forces(heaviest: HeaviestCells) -> tuple[Array, Array]:
    """The part of the force at right angles to the line from the base to where it presses, and its deviation, N.

    (..., K) each; where it is 0, the deviation is that of the size.
    """
    vectors = heaviest.vectors[..., [0, -1], :]
    directions, sizes = _transverse(vectors, heaviest.points[..., None, :])
    direction = np.where(sizes[..., :1] > 0, directions[..., 0, :], directions[..., 1, :])
    deviations = (heaviest.vectors[..., 1:, :] @ direction[..., None])[..., 0]
    return sizes[..., 0], np.linalg.norm(deviations, axis=-1)


def _transverse(force: Array, point: Array) -> tuple[Array, Array]:
    """Direction, (..., 3), and size, (...), of the part of a force at right angles to the line from B to a point."""
    along = (force * point).sum(axis=-1) / np.maximum((point**2).sum(axis=-1), _TINY)
    across = force - along[..., None] * point
    size = np.linalg.norm(across, axis=-1)
    return across / (size + _TINY)[..., None], size


def _about_best(weights: Array, forces: Array) -> tuple[Array, Array]:
    """The first of K forces with their deviations, (..., K, 2 + T, M), and their mean squares about it, (..., M, M)."""
    best = forces[..., 0, 0, :]
    rows = np.concatenate([forces[..., 1:, :], forces[..., :1, :] - best[..., None, None, :]], axis=-2)
    rows = rows * np.sqrt(weights)[..., None, None]
    rows = rows.reshape(*rows.shape[:-3], -1, rows.shape[-1])
    return best, np.swapaxes(rows, -1, -2) @ rows


def _direction_std(vector: Array, covariance: Array) -> Array:
    """Root mean square of the angle between a vector, (..., 3), and what it may be, rad, (...)."""
    square = np.maximum((vector**2).sum(axis=-1), _TINY)
    along = ((vector[..., None, :] @ covariance)[..., 0, :] * vector).sum(axis=-1) / square
    return np.sqrt(np.maximum(np.trace(covariance, axis1=-2, axis2=-1) - along, 0) / square)


def _covariance_of_several(responses: Array, uncertain: Array, forces: Array, usual: float) -> Array:
    """The covariance of the forces in M cells, (M, M) N^2, each of which may equally press on the adjacent cell.

    `responses` are whitened, (S, M), and `uncertain` is the covariance of what they leave, friction included, (S, S).
    """
    pressing = forces > 0
    near = pressing | ~pressing.any()  # if none is found, there may be one anywhere
    near[1:] |= pressing[:-1]
    near[:-1] |= pressing[1:]
    shared = usual**2 * near[:, None] * responses.T
    return np.asarray(usual**2 * np.diag(near) - shared @ np.linalg.solve(responses @ shared + uncertain, shared.T))


def _std_of_sum(covariance: Array, weights: Array) -> Array:
    return np.sqrt(weights @ covariance @ weights)


def _stated(contact: ContactForce, free: NDArray[np.bool_], unknown: NDArray[np.bool_]) -> ContactForce:
    """No force where nothing touches, and NaN where too little is read."""
    nan = np.nan

    def of(value: Array, without: Any) -> Array:
        more = (..., *[None] * (value.ndim - free.ndim))
        return np.where(unknown[more], nan, np.where(free[more], without, value))

    without = (
        0.0,
        nan,
        contact.force_std,
        nan,
        0.0,
        contact.vector_covariance,
        nan,
        nan,
        0.0,
        contact.transverse_force_std,
    )
    return ContactForce(*(of(np.asarray(value), nothing) for value, nothing in zip(contact, without, strict=True)))


def _sparse(rows: Array, blocks: NDArray[np.int_], count: int) -> "csr_array":
    """A matrix of rows (M, n), each in one of `count` blocks of n columns."""
    from scipy.sparse import csr_array

    M, n = rows.shape
    indices = (n * blocks[:, None] + np.arange(n)).ravel()
    matrix = csr_array((rows.ravel(), indices, n * np.arange(M + 1)), shape=(M, n * count))
    matrix.eliminate_zeros()
    return matrix


def _product(matrix: "csr_array", values: Array, cells: int) -> Array:
    """A sparse matrix, (M C, B), times (..., B, S), as (M, S, ..., C)."""
    flat = np.moveaxis(values, (-2, -1), (0, 1))
    found = np.asarray(matrix @ flat.reshape(matrix.shape[1], -1))
    by_cell = np.ascontiguousarray(np.swapaxes(found.reshape(-1, cells, found.shape[-1]), -1, -2))
    return by_cell.reshape(-1, *flat.shape[1:], cells)
