"""Contact of a finger: the force as a vector, its place along and around the finger, and their uncertainty.

In most grasps a finger touches one object. Driving torque and weight leave the values r = z - g(q) - A (q_0 - q) that
are read unexplained: q is a shape close to the true one, first that of `gaussian`, then that under the force found so;
A are the slopes of the values there, and q_0 the joints without a load. If noise and uncertainty explain them, there is
no contact. A load on a link, with the wrench f = (moment about the link's origin, force) in its frame, changes them by

    G f ,   G = A C J^T ,

with J the motion of the link and C the compliance of the joints. All that lies beyond a joint turns it alike, so that
the sums of  (A C) (screw of the joint)  from the base to a link give its G.

`contact_cells` divides the surface into cells. In a cell a force of 1 N presses inward; friction in the directions of
the surface, the place along and across the cell, and the link on which it acts, change its wrench linearly, each by an
independent standard normal variable. `force_posterior` has the posterior of the size F of the force. These variables
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

Leading axes are free; S values, D joint positions, one deformation after the other, L links, P places, C cells, T
tangents: two, or the one in its plane of a finger that only bends.

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
from soft_gripper.estimators.batches import LazyArray, map_batches, memoized
from soft_gripper.estimators.contact_cells import SMOOTH_FRICTION, SurfaceCells
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.force_posterior import (
    CellFits,
    CellPosterior,
    Cells,
    ContactPosterior,
    ForcePrior,
    cell_posterior,
    contact_posterior,
    fit_cells,
    weighted_posterior,
    whitening_matrix,
)
from soft_gripper.estimators.free_motion import AT_REST, STILL, FreeMotion, Lag, may_exceed
from soft_gripper.estimators.gaussian import GaussianShape, kalman_gain
from soft_gripper.estimators.mechanics import BentFinger, Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import Zeroing
from soft_gripper.fingers.spatial_chain import Posture, vector_product
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel

if TYPE_CHECKING:  # imported where it is made
    from scipy.sparse import csr_array

_FALSE_ALARM_RATE = 1e-3  # P(noise alone exceeds the noise threshold)
_MAX_HEAVY_CELLS = 96  # cells over which means are taken
_TINY = 1e-30
_HALF_WIDTH_STDS = math.sqrt(3)  # standard deviations from the middle of a cell to its sides
_PLACE_INFORMATION = 1e-3  # prior information on the place within the most probable cell
_ITERATIONS = 2  # of the most probable force and the deviations within its cell, in turn
# Friction at the limit of the cone, and the place at the sides of a face, in standard deviations.
_EXTREME_DEVIATIONS = np.array(
    [[i, j, 0, k] for i, j in ((-1, 0), (1, 0), (0, -1), (0, 1)) for k in (-_HALF_WIDTH_STDS, _HALF_WIDTH_STDS)]
)


class LinearizedResidual(NamedTuple):
    """Residual of driving torque and weight, linearized about a shape."""

    q: Array  # (..., D)
    bent: BentFinger  # at q
    slopes: Array  # A, (..., S, D)
    read_count: Array  # (...) number of finite values
    residual: Array  # r, (..., S)
    covariance: Array  # (..., S, S), of noise, model and motion
    is_moving: Array = STILL  # (...) 1 where a free finger in motion may have such residuals, else 0


class HeaviestCells(NamedTuple):
    """Forces in the K cells that hold nearly all of the posterior, the most probable one first."""

    cells: NDArray[np.int_]  # (..., K)
    weights: Array  # (..., K), 1 in all
    force: Array  # (..., K) N
    z: Array  # (..., K, D), deviations within the cell, in standard deviations
    covariance: Array  # (..., K, D, D), of these
    local: Array  # (..., 3) N, the force in the first cell in the frame of its link
    vectors: Array  # (..., K, 2 + T, 3) N in B: the force, and what friction and size add to it, one deviation each
    arc_length: Array  # (..., K) m, where it presses
    points: Array  # (..., K, 3) m in B, there on the axis of the finger


class SingleForceFit(NamedTuple):
    """Fit and posterior of one force in every cell."""

    linearized: LinearizedResidual
    cell_fits: CellFits
    posterior: CellPosterior
    heaviest: LazyArray[HeaviestCells]


class _SeveralForces(NamedTuple):
    """Fit of several forces on a side to one sample."""

    fields: Mapping[str, Array | float]  # of `ContactForce`, for their sum
    torque: Array  # (D) at the joints
    chi_squared: float  # of the residual


@dataclass(frozen=True)
class SurfaceContact:
    """Contact on the surface of a finger that explains the readings."""

    mechanics: Mechanics

    def explain(self, linearized: LinearizedResidual) -> SingleForceFit:
        """Fits a force per cell."""
        W = whitening_matrix(linearized.covariance)
        cells = self.cells(linearized.q, linearized.bent, W @ linearized.slopes)
        r = (W @ linearized.residual[..., None])[..., 0]
        refines = not self.mechanics.is_planar  # there, friction has cells of its own
        cell_fits = fit_cells(r, cells, self._force_prior.max_force, refines)
        posterior = cell_posterior(cell_fits, linearized.read_count, self._force_prior)
        heaviest = LazyArray(lambda: self._heaviest_cells(linearized, cell_fits, posterior))
        return SingleForceFit(linearized, cell_fits, posterior, heaviest)

    def reported_contact(self, fit: SingleForceFit) -> tuple[ContactForce, Array]:
        """Contact, and its torques at the joints, (..., D); none where noise explains the values or too few are read.

        The contact is one force, or several on its side where one leaves more than noise and enough values are read.
        """
        linearized, cell_fits, posterior, _ = fit
        contact, torque, side = self.best_contact(fit)
        noise = _noise_threshold(linearized.read_count - self.min_read_count)
        has_several = (linearized.read_count > self.min_read_count) & (cell_fits.chi_squared.min(axis=-1) > noise)
        if has_several.any():
            contact, torque = self._put_several_forces(has_several, side, contact, torque, fit)
        is_free = (cell_fits.r**2).sum(axis=-1) < _noise_threshold(linearized.read_count)
        is_unknown = (linearized.read_count < self.min_read_count) | (is_free & (linearized.is_moving > 0))
        contact = contact._replace(force_std=np.where(is_free, self._tip_force_std(posterior), contact.force_std))
        return _mask_contact(contact, is_free, is_unknown), np.where((is_free | is_unknown)[..., None], 0.0, torque)

    def _tip_force_std(self, posterior: CellPosterior) -> Array:
        """Standard deviation of a force on the tip, N, (...): the force that is overlooked first."""
        surface = self.surface
        tip_cells = np.flatnonzero(surface.on_face & ~surface.rough & (surface.place == surface.place.max()))
        return np.asarray(posterior.std[..., tip_cells].max(axis=-1))

    def posterior(self, fit: SingleForceFit) -> ContactPosterior:
        """Posterior of the contact."""
        linearized, cell_fits, posterior, heaviest = fit
        length = self.mechanics.layout.finger.length
        min_location = self.mechanics.uncertainty.nearest_contact * length
        transverse = LazyArray(lambda: weighted_posterior(*transverse_forces(heaviest.value), heaviest.value.weights))
        return contact_posterior(
            cell_fits,
            posterior,
            transverse,
            linearized.read_count,
            length,
            self._force_prior,
            min_location,
            linearized.is_moving,
            self._cone_cells(cell_fits.cells),
        )

    @property
    def min_read_count(self) -> int:
        """Minimum number of values for a force: its unknowns, its face among them."""
        return 2 if self.mechanics.is_planar else 3

    def cells(self, q: Array, bent: BentFinger, slopes: Array) -> Cells:
        """Changes of the values by forces in all cells, of a finger that is bent by `q`."""
        surface, posture, links = self.surface, bent.posture, self.mechanics.links
        compliant = (slopes * self.mechanics.compliance(q)[..., None, :])[..., self.mechanics.to_chain]
        screw_effects = np.swapaxes(compliant, -1, -2)[..., :, None, :] * posture.screws[..., None]  # (..., D, 6, S)
        sums = np.concatenate([np.zeros_like(screw_effects[..., :1, :, :]), screw_effects.cumsum(axis=-3)], axis=-3)
        moments, forces = np.split(sums[..., links, :, :], 2, axis=-2)
        R = np.swapaxes(posture.rotations[..., links, :, :], -1, -2)
        origins = posture.origins[..., links, :]
        shifts = vector_product(np.swapaxes(moments, -1, -2), origins[..., None, :])  # forces act at the links' origins
        forces = forces + np.swapaxes(shifts, -1, -2)
        wrench_effects = [np.concatenate([R @ moments, R @ forces], axis=-2)]  # (..., L, 6, S)
        if self.mechanics.is_planar:
            link, joint, _ = surface.pairs
            wrench_effects.append(R[..., link, :, :] @ np.diff(moments, axis=-3)[..., joint, :, :])  # (..., X, 3, S)
        rows = [effects.reshape(*effects.shape[:-3], -1, effects.shape[-1]) for effects in wrench_effects]
        changes = _product(self._response_matrix, np.concatenate(rows, axis=-2), len(surface.place))
        response, deviations = np.moveaxis(changes[0], 0, -1), np.moveaxis(changes[1:], (0, 1), (-2, -1))
        return Cells(response, deviations, surface.place, surface.side, surface.prior, surface.angle)

    @cached_property
    def _response_matrix(self) -> "csr_array":
        """Matrix from the effects of wrenches on links to those of forces in cells, ((1 + D) C, 6 L).

        If the finger only bends, it has 3 X more columns, for moments at the joint and on the link of each pair.
        """
        from scipy.sparse import block_diag

        surface = self.surface
        wrenches = np.swapaxes(surface.wrenches, 0, 1)
        rows, links = wrenches.reshape(-1, 6), np.tile(surface.link, len(wrenches))
        blocks = [_sparse(rows, links, len(self.mechanics.links))]
        if self.mechanics.is_planar:
            link, _, pair_index = surface.pairs
            blocks.append(_sparse(surface.straddled, pair_index, len(link)))
        return block_diag(blocks, "csr")

    def best_contact(self, fit: SingleForceFit) -> tuple[ContactForce, Array, NDArray[np.int_]]:
        """Most probable contact, its torques at the joints, (..., D), and the side that it presses, (...)."""
        surface, heaviest = self.surface, fit.heaviest.value
        linearized, _, posterior, _ = fit
        cells, force, z, z_covariance = heaviest.cells, heaviest.force, heaviest.z, heaviest.covariance
        vector, vector_covariance = _vector_with_covariance(heaviest.weights, heaviest.vectors)
        sizes, deviations = transverse_forces(heaviest)
        T, best = surface.tangents, cells[..., 0]
        place = heaviest.arc_length[..., 0]
        cross_force = -heaviest.local[..., 0]
        force_std, place_std = self._force_place_stds(posterior, cross_force, place, z_covariance[..., 0, T, T])
        contact = ContactForce(
            force=cross_force,
            arc_length=place,
            force_std=force_std,
            arc_length_std=place_std,
            vector=vector,
            vector_covariance=vector_covariance,
            direction_std=_direction_std(vector, vector_covariance),
            side=surface.angle[cells[..., 0]],
            transverse_force=sizes[..., 0],
            transverse_force_std=np.sqrt(
                (heaviest.weights * ((sizes - sizes[..., :1]) ** 2 + deviations**2)).sum(axis=-1)
            ),
        )
        wrenches = surface.wrenches[cells[..., 0]]
        wrench = wrenches[..., 0, :] + (z[..., :1, : 2 * T] @ wrenches[..., 1:, :])[..., 0, :]
        torque = self._torques(linearized.bent.posture, surface.link[cells[..., :1]], force[..., :1] * wrench)
        if self.mechanics.is_planar:
            torque = torque + self._straddled_torques(linearized.bent.posture, best, force[..., :1] * z[..., 0, -1:])
        return contact, torque, surface.side[cells[..., 0]]

    def _heaviest_cells(
        self, linearized: LinearizedResidual, cell_fits: CellFits, posterior: CellPosterior
    ) -> HeaviestCells:
        """Forces in the cells that hold nearly all of the posterior."""
        surface, max_force = self.surface, self._force_prior.max_force
        weights, cells = _rank_cells(posterior)
        force = np.minimum(_take_cells(posterior.mean, cells), max_force)
        force[..., 0] = np.clip(_take_cells(posterior.force, cells[..., :1])[..., 0], 0, max_force)
        response = _take_cells(cell_fits.cells.response, cells)
        deviations = _take_cells(cell_fits.cells.deviations, cells)
        z, z_covariance, z_slopes = _deviation_posterior(cell_fits.r, force, response, deviations)
        if self.mechanics.is_planar:  # in space, friction along the finger would be taken for the place
            best_cell = force[..., 0], response[..., 0, :], deviations[..., 0, :, :]
            force[..., 0], z[..., 0, :] = self._fit_best_cell(cell_fits.r, *best_cell)
        R = _take_cells(linearized.bent.posture.rotations, self.mechanics.links[surface.link[cells]])
        std = _take_cells(posterior.std, cells)
        local = _force_vectors(surface.directions[cells], force, std, z, z_covariance, z_slopes)
        arc_length = surface.arc_length[cells] + surface.extent[cells] * z[..., surface.tangents]
        arc_length = arc_length.clip(0, self.mechanics.layout.finger.length)
        points = self._axis_points(linearized.bent.posture.frames, arc_length)
        vectors = local @ np.swapaxes(R, -1, -2)
        return HeaviestCells(cells, weights, force, z, z_covariance, local[..., 0, 0, :], vectors, arc_length, points)

    def _axis_points(self, frames: Array, arc_length: Array) -> Array:
        """Points on the axis of the finger, (..., K, 3) m in B, at arc lengths, (..., K); `frames` are the chain's."""
        finger = self.mechanics.layout.finger
        link = np.searchsorted(finger.joint_arc_lengths, arc_length)
        link_frames = _take_cells(frames, self.mechanics.links[link])
        height = arc_length - finger.link_ends[:-1][link]
        return np.asarray(link_frames[..., :3, 3] + height[..., None] * link_frames[..., :3, 2])

    def _fit_best_cell(self, r: Array, force: Array, response: Array, deviations: Array) -> tuple[Array, Array]:
        """Fits force, (...) N, and deviations, (..., D), in the most probable cell, whose place is free."""
        usual_force, max_force = self._force_prior
        place_index = self.surface.tangents
        place_changes = deviations[..., place_index, :]
        other_changes = np.delete(deviations, place_index, axis=-2)
        for _ in range(_ITERATIONS):  # deviations other than that of the place follow the force
            U = force[..., None, None] * other_changes
            weights = np.linalg.inv(np.swapaxes(U, -1, -2) @ U + np.eye(r.shape[-1]))
            # r is nearly linear in the force and in force times place
            responses = np.stack([response, place_changes], axis=-2)
            information = responses @ weights @ np.swapaxes(responses, -1, -2)
            information[..., 0, 0] += usual_force**-2
            information[..., 1, 1] += _PLACE_INFORMATION / np.maximum(force, _TINY) ** 2
            size, product = np.moveaxis(np.linalg.solve(information, responses @ weights @ r[..., None])[..., 0], -1, 0)
            place = (product / np.where(size == 0, _TINY, size)).clip(-_HALF_WIDTH_STDS, _HALF_WIDTH_STDS)
            c = response + place[..., None] * place_changes
            weighted = (weights @ c[..., None])[..., 0]
            force = ((weighted * r).sum(axis=-1) / ((weighted * c).sum(axis=-1) + usual_force**-2)).clip(0, max_force)
        residual = r - force[..., None] * c
        z = (U @ weights @ residual[..., None])[..., 0]
        return force, np.insert(z, place_index, place, axis=-1)

    def _force_place_stds(
        self, posterior: CellPosterior, force: Array, place: Array, place_variance: Array
    ) -> tuple[Array, Array]:
        """Root mean square distances of the posterior from a normal force, N, and a location, m, (...).

        `place_variance` is the posterior over the prior variance of the place within the most probable cell.
        """
        surface, force, place = self.surface, force[..., None], place[..., None]
        factors = -surface.directions[:, 0, 0]
        squares = factors**2 * posterior.square - 2 * factors * posterior.mean * force + force**2
        place_squares = (surface.arc_length - place) ** 2 + surface.extent**2 * place_variance[..., None]
        force_square = np.maximum((posterior.weight * squares).sum(axis=-1), 0)
        return np.sqrt(force_square), np.sqrt((posterior.weight * place_squares).sum(axis=-1))

    def _put_several_forces(
        self,
        is_chosen: NDArray[np.bool_],
        side: NDArray[np.int_],
        contact: ContactForce,
        torque: Array,
        fit: SingleForceFit,
    ) -> tuple[ContactForce, Array]:
        """Replaces contact and torque of chosen samples, of K, by several forces, if these explain more than one.

        One force may rub along the finger and across it freely, several less.
        """
        contact, torque = ContactForce(*(np.array(values) for values in contact)), torque.copy()
        for k in np.flatnonzero(is_chosen & np.isin(side, self.surface.side[self._smooth_places])):
            forces_fit = self._fit_several_forces(int(k), int(side[k]), fit)
            if forces_fit.chi_squared <= fit.cell_fits.chi_squared[k].min():
                torque[k] = forces_fit.torque
                for name, value in forces_fit.fields.items():
                    getattr(contact, name)[k] = value
        return contact, torque

    def _fit_several_forces(self, k: int, side: int, fit: SingleForceFit) -> _SeveralForces:
        """Fits forces on a side to sample k."""
        from scipy.optimize import nnls

        linearized, cell_fits, _, _ = fit
        surface, uncertainty = self.surface, self.mechanics.uncertainty
        cells = np.flatnonzero(self._smooth_places & (surface.side == side))
        responses = cell_fits.cells.response[k, cells].T
        usual_force, tangents = self._force_prior.usual_force, surface.tangents
        rows = np.vstack([responses, np.eye(len(cells)) / usual_force])
        forces, _ = nnls(rows, np.append(cell_fits.r[k], np.zeros(len(cells))))
        friction_stds = uncertainty.friction / math.sqrt(3) / SMOOTH_FRICTION * forces
        friction = friction_stds[:, None, None] * cell_fits.cells.deviations[k, cells, :tangents]
        friction = friction.reshape(-1, len(responses))
        noise = np.eye(len(responses)) + friction.T @ friction
        residual = cell_fits.r[k] - responses @ forces
        covariance = _several_covariance(responses, noise, forces, usual_force)
        total_force, arc_lengths = forces.sum(), surface.arc_length[cells]
        divisor = total_force if total_force > 0 else np.nan
        center = forces @ arc_lengths / divisor
        directions = surface.directions[cells, 0]
        frames = self.mechanics.links[surface.link[cells]]
        bent = linearized.bent.posture
        base_directions = (bent.rotations[k, frames] @ directions[..., None])[..., 0]
        posture = Posture(*(np.broadcast_to(part[k], (len(cells), *part.shape[1:])) for part in bent))
        wrenches = forces[:, None] * surface.wrenches[cells, 0]
        vector, vector_covariance = forces @ base_directions, base_directions.T @ covariance @ base_directions
        (point,) = self._axis_points(bent.frames[k], np.array([center if total_force > 0 else 0.0]))
        transverse_direction, transverse = _transverse(vector, point)
        fields = {
            "force": float(-forces @ directions[:, 0]),
            "arc_length": float(center),
            "force_std": float(_sum_std(covariance, directions[:, 0])),
            "arc_length_std": float(_sum_std(covariance, (arc_lengths - center) / divisor)),
            "vector": vector,
            "vector_covariance": vector_covariance,
            "transverse_force": transverse,
            "transverse_force_std": np.sqrt(transverse_direction @ vector_covariance @ transverse_direction),
        }
        torque = self._torques(posture, surface.link[cells][:, None], wrenches).sum(axis=0)
        return _SeveralForces(fields, torque, float(residual @ np.linalg.solve(noise, residual)))

    @cached_property
    def _smooth_places(self) -> NDArray[np.bool_]:
        """Mask of the cells that are smooth, on faces, and where a contact may be, (C)."""
        surface, length = self.surface, self.mechanics.layout.finger.length
        min_location = self.mechanics.uncertainty.nearest_contact * length
        return surface.on_face & ~surface.rough & (min_location <= surface.arc_length) & (surface.arc_length < length)

    def _torques(self, posture: Posture, link: NDArray[np.int_], wrench: Array) -> Array:
        """Torques at the joints, (..., D), of a wrench in the frame of a link, (..., 6) and (..., 1)."""
        frames = self.mechanics.links[link]
        transforms = _take_cells(posture.frames, frames)[..., 0, :, :]
        R, origins = transforms[..., :3, :3], transforms[..., :3, 3]
        moment, force = ((R @ vector[..., None])[..., 0] for vector in (wrench[..., :3], wrench[..., 3:]))
        base_wrench = np.concatenate([moment + vector_product(origins, force), force], axis=-1)
        is_moved = frames > np.arange(posture.screws.shape[-2])
        torques = is_moved * (posture.screws @ base_wrench[..., None])[..., 0]
        return np.asarray(torques[..., self.mechanics.from_chain])

    def _cone_cells(self, cells: Cells) -> Cells:
        """Cells of several forces, with friction at the cone: sums of these replace all other cells.

        If the finger only bends, they are the cells with the most friction in every place; else they are on the middles
        and the sides of faces.
        """
        surface = self.surface
        if self.mechanics.is_planar:
            rough_cells = np.flatnonzero(surface.rough)
            begins = np.diff(surface.arc_length[rough_cells], prepend=np.nan, append=np.nan) != 0
            numbers = rough_cells[begins[:-1] | begins[1:]]
            response = cells.response[..., numbers, :]
        else:
            numbers = np.flatnonzero(surface.rough & surface.on_face & (cells.place % 2 == 1))
            response = _EXTREME_DEVIATIONS @ cells.deviations[..., numbers, :, :]
            response = cells.response[..., numbers, None, :] + response
            response = response.reshape(*response.shape[:-3], -1, response.shape[-1])
            numbers = np.repeat(numbers, len(_EXTREME_DEVIATIONS))
        fields = cells.place[numbers], cells.side[numbers], cells.prior[numbers], cells.angle[numbers]
        return Cells(response, cells.deviations, *fields)

    def _straddled_torques(self, posture: Posture, cell: NDArray[np.int_], force: Array) -> Array:
        """Torques at the joints, (..., D), of forces, (..., 1), on the lever of a cell that straddles two links."""
        surface, mechanics = self.surface, self.mechanics
        R = np.take_along_axis(posture.rotations, mechanics.links[surface.link[cell]][..., None, None, None], axis=-3)
        moment = (R[..., 0, :, :] @ (force * surface.straddled[cell])[..., None])[..., 0]
        is_adjacent = mechanics.chain.segments == surface.nearest_joint[cell][..., None]
        torques = is_adjacent * (posture.screws[..., :3] @ moment[..., None])[..., 0]
        return np.asarray(torques[..., mechanics.from_chain])

    @property
    def _force_prior(self) -> ForcePrior:
        return ForcePrior(self.mechanics.usual_force, self.mechanics.uncertainty.largest_force)

    @cached_property
    def surface(self) -> SurfaceCells:
        """The cells of the finger."""
        layout = self.mechanics.layout
        return SurfaceCells.from_finger(layout.finger, layout.deformations, self.mechanics.uncertainty.friction)


@dataclass(frozen=True)
class ContactShape:
    """The estimator `contact` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between the samples of a finger that moves

    def __call__(
        self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST, std: Array | None = None
    ) -> ShapeEstimate:
        """Estimates joint positions, covariance and contact; see ShapeFunction, and for `std` GaussianShape.

        The contact is NaN where too few values are read (`SurfaceContact.min_read_count`), or where none is found on a
        moving finger; `lag` is that of a free finger in motion, (..., D) each.
        """
        return self._map_batches(self._shape, readings, driving, gravity, lag, std)

    def posterior(
        self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST, std: Array | None = None
    ) -> ContactPosterior:
        """Posterior of one contact; see `__call__`."""
        return self._map_batches(self._posterior, readings, driving, gravity, lag, std)

    @cached_property
    def motion(self) -> FreeMotion:
        """The motion of the finger while nothing touches it."""
        return FreeMotion(self._gaussian.mechanics, self.period)

    @property
    def zeroing(self) -> Zeroing | None:
        """The block that follows the zeros of the sensors; see GaussianShape."""
        return self._gaussian.zeroing

    def _map_batches(
        self, function: Any, readings: Array, driving: Array, gravity: Array, lag: Lag, std: Array | None
    ) -> Any:
        leading_shape = readings.shape[:-1]
        arrays = driving, gravity, np.full(1, self.uncertainty.any_reading()) if std is None else std, *lag
        inputs = (np.broadcast_to(values, (*leading_shape, values.shape[-1])) for values in arrays)
        return map_batches(function, readings, *inputs)

    def _shape(self, readings: Array, driving: Array, gravity: Array, std: Array, *lag: Array) -> ShapeEstimate:
        shape = memoized(GaussianShape.__call__, self._gaussian, readings, driving, gravity, std)
        fit, q_free = memoized(ContactShape._explain, self, shape.q, readings, driving, gravity, std, *lag)
        return self._loaded_shape(shape, fit, q_free, readings, driving, gravity, std)

    def _loaded_shape(
        self,
        shape: ShapeEstimate,
        fit: SingleForceFit,
        q_free: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        std: Array,
    ) -> ShapeEstimate:
        """The shape under the reported contact, from that of `gaussian`."""
        contact, torque = self.contact.reported_contact(fit)
        loaded_q = self._loaded_joints(fit.linearized, q_free, torque, readings, driving, gravity, std)
        q = np.where(torque.any(axis=-1, keepdims=True), loaded_q, shape.q)
        return ShapeEstimate(q, shape.covariance, contact)

    def _posterior(self, readings: Array, driving: Array, gravity: Array, std: Array, *lag: Array) -> ContactPosterior:
        shape = memoized(GaussianShape.__call__, self._gaussian, readings, driving, gravity, std)
        fit, q_free = memoized(ContactShape._explain, self, shape.q, readings, driving, gravity, std, *lag)
        samples = readings, driving, gravity, std
        loaded_shape = LazyArray(lambda: self._loaded_shape(shape, fit, q_free, *samples))
        return self.contact.posterior(fit)._replace(shape=loaded_shape)

    def _explain(
        self,
        q: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        std: Array | None = None,
        damping: Array = AT_REST.damping,
        inertia: Array = AT_REST.inertia,
    ) -> tuple[SingleForceFit, Array]:
        """Fits a force per cell, linearized about `q` first, then about the finger under the best force; and q_0."""
        lag = Lag(damping, inertia)
        linearized, q_free = self._linearize(q, readings, driving, gravity, lag, std)
        fit = self.contact.explain(linearized)
        for _ in range(self._pass_count - 1):
            torque = self.contact.best_contact(fit)[1]
            q = self._loaded_joints(linearized, q_free, torque, readings, driving, gravity, std)
            linearized, q_free = self._linearize(q, readings, driving, gravity, lag, std)
            fit = self.contact.explain(linearized)
        return fit, q_free

    @cached_property
    def _pass_count(self) -> int:
        """Number of linearizations; one suffices where the load changes only the posture."""
        return 1 if self.contact.mechanics.is_planar and self.layout.finger.elastic_law is None else 2

    def _loaded_joints(
        self,
        linearized: LinearizedResidual,
        q_free: Array,
        torque: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        std: Array | None,
    ) -> Array:
        """Joint positions under torques of a contact, (..., D); their residual is distributed as by `gaussian`."""
        mechanics = self._gaussian.mechanics
        errors = self._gaussian.extrapolation(readings, driving, gravity)
        variance = self._gaussian.read(readings, std, errors).variance
        load_change = mechanics.compliance(linearized.q) * torque
        residual = linearized.residual - (linearized.slopes @ load_change[..., None])[..., 0]
        prior = mechanics.prior(linearized.bent, linearized.q, driving, errors)
        gain, _ = kalman_gain(linearized.slopes, prior, variance)
        return np.asarray(q_free + load_change + (gain @ residual[..., None])[..., 0])

    def _linearize(
        self,
        q: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        lag: Lag = AT_REST,
        std: Array | None = None,
    ) -> tuple[LinearizedResidual, Array]:
        """Linearizes about joint positions `q`; also returns the joints without a load, q_0, (..., D).

        The stiffness may err as the bend per driving torque does; then every bend errs by this fraction.
        """
        mechanics = self._gaussian.mechanics
        errors = self._gaussian.extrapolation(readings, driving, gravity)
        values, variance = self._gaussian.read(readings, std, errors)
        bent, (prediction, A) = mechanics.bent_finger(q), self.layout.values_at(q)
        q_free = mechanics.linearized_positions(q, driving + mechanics.weight(bent, gravity))
        residual = values - prediction - (A @ (q_free - q)[..., None])[..., 0]
        stiffness = A @ np.swapaxes(mechanics.bend_changes * q[..., None, :], -1, -2)
        model = A @ mechanics.model_covariance(q, driving, errors) @ np.swapaxes(A, -1, -2)
        covariance = model + stiffness @ np.swapaxes(stiffness, -1, -2)
        covariance = covariance + variance[..., None] * np.eye(A.shape[-2])
        read_count = (variance < UNKNOWN / 2).sum(axis=-1, dtype=float)
        motion = lag.reading_covariance(A)
        exceeds = may_exceed(motion, covariance, _noise_threshold(read_count))
        return LinearizedResidual(q, bent, A, read_count, residual, covariance + motion, exceeds), q_free

    @cached_property
    def contact(self) -> SurfaceContact:
        """Contacts that explain readings."""
        return SurfaceContact(self._gaussian.mechanics)

    @cached_property
    def _gaussian(self) -> GaussianShape:
        return GaussianShape(self.layout, self.uncertainty, self.period)


def _noise_threshold(read_count: Array) -> Array:
    """Misfit threshold for noise, (...), by the number of values that are read."""
    from scipy.special import chdtri

    return np.asarray(chdtri(np.maximum(read_count, 1), _FALSE_ALARM_RATE))


def _rank_cells(posterior: CellPosterior) -> tuple[Array, NDArray[np.int_]]:
    """Weights that sum to 1, and numbers, (..., K), of the most probable cell and the heaviest others."""
    rank = posterior.weight.copy()
    np.put_along_axis(rank, posterior.best_cell[..., None], np.inf, axis=-1)
    cells = np.argsort(-rank, axis=-1)[..., :_MAX_HEAVY_CELLS]
    weights = np.take_along_axis(posterior.weight, cells, axis=-1)
    return weights / weights.sum(axis=-1, keepdims=True), cells


def _take_cells(values: Array, numbers: NDArray[np.int_]) -> Array:
    """Values chosen for each sample, (..., C, ...), by their numbers, (..., K)."""
    samples = np.arange(numbers.size // numbers.shape[-1]).reshape(*numbers.shape[:-1], 1)
    rows = values.reshape(-1, *values.shape[numbers.ndim :])
    return np.asarray(rows[numbers + values.shape[numbers.ndim - 1] * samples])


def _deviation_posterior(r: Array, force: Array, response: Array, deviations: Array) -> tuple[Array, Array, Array]:
    """Deviations in cells, (..., K, D) standard deviations, given readings and force.

    Also returns their covariance, and their derivative by the force.
    """
    # (S, ..., K) and (D, S, ..., K): sums over short first axes are quick
    r, c = np.moveaxis(r, -1, 0)[..., None], np.moveaxis(response, -1, 0)
    U = np.multiply(force, np.moveaxis(deviations, (-2, -1), (0, 1)), order="C")
    products, identity = np.einsum("ds...,es...->de...", U, U), np.eye(len(U))
    covariance = _inverse(products + identity.reshape(*identity.shape, *[1] * force.ndim))
    projections = (np.einsum("ds...,s...->d...", U, vectors) for vectors in (r - force * c, -c))
    z, z_slopes = (np.moveaxis(np.einsum("de...,e...->d...", covariance, vectors), 0, -1) for vectors in projections)
    return z, np.moveaxis(covariance, (0, 1), (-2, -1)), z_slopes


def _inverse(matrices: Array) -> Array:
    """Inverses of small positive definite matrices, (D, D, ...), by Gauss and Jordan."""
    inverse = matrices.copy()
    for k in range(len(inverse)):
        pivot = 1 / inverse[k, k]
        row, column = inverse[k] * pivot, inverse[:, k].copy()
        inverse -= column[:, None] * row
        inverse[k], inverse[:, k] = row, -column * pivot
        inverse[k, k] = pivot
    return inverse


def _force_vectors(
    directions: Array, force: Array, std: Array, z: Array, z_covariance: Array, z_slopes: Array
) -> Array:
    """Forces in the frames of their links and T + 1 independent deviations, (..., K, 2 + T, 3) N.

    See `_deviation_posterior` for z and its derivative, `SurfaceCells` for the directions.
    """
    T = directions.shape[-2] - 1
    unit = directions[..., :1, :] + z[..., None, :T] @ directions[..., 1:, :]
    sizes = force[..., None, None]
    friction = np.swapaxes(np.linalg.cholesky(z_covariance[..., :T, :T]), -1, -2) @ directions[..., 1:, :]
    size_slopes = unit + sizes * z_slopes[..., None, :T] @ directions[..., 1:, :]
    return np.concatenate([sizes * unit, sizes * friction, std[..., None, None] * size_slopes], axis=-2)


def transverse_forces(heaviest: HeaviestCells) -> tuple[Array, Array]:
    """Component of the force at right angles to the line from base to contact, and its deviation, (..., K) N.

    Where it is 0, the deviation is that of the size.
    """
    vectors = heaviest.vectors[..., [0, -1], :]
    directions, sizes = _transverse(vectors, heaviest.points[..., None, :])
    direction = np.where(sizes[..., :1] > 0, directions[..., 0, :], directions[..., 1, :])
    deviations = (heaviest.vectors[..., 1:, :] @ direction[..., None])[..., 0]
    return sizes[..., 0], np.linalg.norm(deviations, axis=-1)


def _transverse(force: Array, point: Array) -> tuple[Array, Array]:
    """Direction, (..., 3), and size, (...), of the component of a force at right angles to the line to a point."""
    ratio = (force * point).sum(axis=-1) / np.maximum((point**2).sum(axis=-1), _TINY)
    component = force - ratio[..., None] * point
    size = np.linalg.norm(component, axis=-1)
    return component / (size + _TINY)[..., None], size


def _vector_with_covariance(weights: Array, forces: Array) -> tuple[Array, Array]:
    """First of K forces with their deviations, (..., K, 2 + T, M), and their mean squares about it, (..., M, M)."""
    best = forces[..., 0, 0, :]
    rows = np.concatenate([forces[..., 1:, :], forces[..., :1, :] - best[..., None, None, :]], axis=-2)
    rows = rows * np.sqrt(weights)[..., None, None]
    rows = rows.reshape(*rows.shape[:-3], -1, rows.shape[-1])
    return best, np.swapaxes(rows, -1, -2) @ rows


def _direction_std(vector: Array, covariance: Array) -> Array:
    """Standard deviation of the direction of a vector, (..., 3), rad, (...)."""
    square = np.maximum((vector**2).sum(axis=-1), _TINY)
    axial_variance = ((vector[..., None, :] @ covariance)[..., 0, :] * vector).sum(axis=-1) / square
    return np.sqrt(np.maximum(np.trace(covariance, axis1=-2, axis2=-1) - axial_variance, 0) / square)


def _several_covariance(responses: Array, noise: Array, forces: Array, usual_force: float) -> Array:
    """Covariance of the forces in M cells, (M, M) N^2; each force may equally press on the adjacent cell.

    `responses` are whitened, (S, M), and `noise` is the covariance of what they leave, friction included, (S, S).
    """
    is_pressing = forces > 0
    is_possible = is_pressing | ~is_pressing.any()  # if none is found, there may be one anywhere
    is_possible[1:] |= is_pressing[:-1]
    is_possible[:-1] |= is_pressing[1:]
    weighted = usual_force**2 * is_possible[:, None] * responses.T
    gain = weighted @ np.linalg.solve(responses @ weighted + noise, weighted.T)
    return np.asarray(usual_force**2 * np.diag(is_possible) - gain)


def _sum_std(covariance: Array, weights: Array) -> Array:
    return np.sqrt(weights @ covariance @ weights)


def _mask_contact(contact: ContactForce, is_free: NDArray[np.bool_], is_unknown: NDArray[np.bool_]) -> ContactForce:
    """Sets the force to 0 where nothing touches, and all fields to NaN where too few values are read."""
    nan = np.nan

    def mask(value: Array, default: Any) -> Array:
        expanded = (..., *[None] * (value.ndim - is_free.ndim))
        return np.where(is_unknown[expanded], nan, np.where(is_free[expanded], default, value))

    forces = 0.0, nan, contact.force_std, nan, 0.0, contact.vector_covariance
    defaults = *forces, nan, nan, 0.0, contact.transverse_force_std
    return ContactForce(*(mask(np.asarray(value), default) for value, default in zip(contact, defaults, strict=True)))


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
    columns = np.moveaxis(values, (-2, -1), (0, 1))
    products = np.asarray(matrix @ columns.reshape(matrix.shape[1], -1))
    products = np.ascontiguousarray(np.swapaxes(products.reshape(-1, cells, products.shape[-1]), -1, -2))
    return products.reshape(-1, *columns.shape[1:], cells)
