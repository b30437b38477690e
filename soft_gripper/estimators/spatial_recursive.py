"""Recursive estimation of a finger that leaves its plane: the estimator `recursive` in space.

The filter is that of the plane (`recursive`), with the modes of a load in every direction. As the bent chain couples
the ways in which its joints yield, readings are linearized about the finger under the load that is known; what the load
adds to the readings is the difference between that finger and the free one.

The contact is that which explains the change of the readings by the load (`SurfaceContact`), r = H C V z , with the
uncertainty of all states. There may be more readings than a load changes independently, so a little noise is added to
each; of the readings count as many as the load explains, beside that noise.

Leading axes are free; R readings, D joints, M modes.
"""

from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import in_parts
from soft_gripper.estimators.estimate import SpatialShape
from soft_gripper.estimators.mechanics import SpatialMechanics, outer
from soft_gripper.estimators.recursive import Filter, RecursiveShape, derive_known, put_out_known
from soft_gripper.estimators.spatial_contact import FEWEST, SpatialPosterior, SurfaceContact, Unexplained
from soft_gripper.estimators.spatial_estimator import SpatialEstimator, SpatialFunction
from soft_gripper.sensors.measurement import MeasurementModel

_REMAINING = 0.3  # of the noise of one sample, in a reading's change by the load
_SEEN = 1e-3  # of the largest slope of the readings by a bend: less is not seen at all


class SpatialRecursiveShape(RecursiveShape):
    """The estimator `recursive` of one finger whose sensors see it leave its plane."""

    _gravity: ClassVar[tuple[int, ...]] = (3,)

    def estimate(self, known: Filter, driving: Array) -> SpatialShape:
        """The shape and the contact after a sample at a driving torque, (..., D)."""
        found: SpatialShape = in_parts(self._estimate, *_arrays(known), driving)
        return found

    def posterior(self, known: Filter, driving: Array) -> SpatialPosterior:
        """Posterior of one contact after a sample at a driving torque, (..., D)."""
        found: SpatialPosterior = in_parts(self._posterior, *_arrays(known), driving)
        return found

    def _estimate(self, q: Array, mean: Array, covariance: Array, driving: Array) -> SpatialShape:
        left, by_joint = self._unexplained(q, mean, covariance, driving)
        contact, _ = self.contact.stated(self.contact.fitted(left), left)
        of_joints = by_joint @ covariance @ np.swapaxes(by_joint, -1, -2) + self.mechanics.deviations
        return SpatialShape(q, of_joints, contact)

    def _posterior(self, q: Array, mean: Array, covariance: Array, driving: Array) -> SpatialPosterior:
        left, _ = self._unexplained(q, mean, covariance, driving)
        return self.contact.posterior(self.contact.fitted(left), left)

    def _unexplained(self, q: Array, mean: Array, covariance: Array, driving: Array) -> tuple[Unexplained, Array]:
        """The change of the readings by the load, and the Jacobian of the joints with respect to the states."""
        M, at, H = self._modes, self.mechanics.posture(q), self.layout.slopes(q)
        by_joint = self._joints_by_state(q, driving, self.mechanics.load_modes(at))
        by_load = H @ by_joint[..., :M]
        of_load = by_load @ covariance[..., :M, :M] @ np.swapaxes(by_load, -1, -2)
        of_load = of_load + H @ self.mechanics.deviations @ np.swapaxes(H, -1, -2)
        stiffness = np.sqrt(covariance[..., M, M])[..., None] * self.layout.predict(q)
        spread = of_load + (_REMAINING * self.uncertainty.reading) ** 2 * np.eye(self.layout.readings)
        explained = np.trace(np.linalg.solve(spread, of_load), axis1=-2, axis2=-1)
        residual = (by_load @ mean[..., :M, None])[..., 0]
        return Unexplained(q, at, H, np.maximum(explained, FEWEST), residual, spread + outer(stiffness)), by_joint

    def _expected(self, mean: Array, driving: Array, weight: Array, modes: Array) -> tuple[Array, Array, Array]:
        known = self.effective_driving(mean, driving) + weight
        strain = self.layout.predict(self.mechanics.free(known))
        bent = self.mechanics.free(known + self._torque(modes, mean))
        loaded, H = self.layout.linearized(bent)
        by_load = (1 + self._gains(mean)) * (loaded - strain)
        return strain, by_load, self._by_state(bent, loaded, H, mean, driving, modes)

    def _is_blind(self, read: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether the bend of any section is barely measured, in either plane."""
        information = self._of_bends
        return np.asarray(np.any(read @ information < 0.5 * information.sum(axis=0), axis=-1))

    @cached_property
    def _of_bends(self) -> Array:
        """Information of the readings on the bends of the sections, in both planes as far as they are seen, (R, B)."""
        layout = self.layout
        sections = layout.joint_sections[:, None] == np.arange(layout.sections)
        bent = [way in ("bending", "sideways") for way in layout.ways]
        by_bend = layout.jacobian @ np.kron(np.eye(len(bent))[:, bent], sections / layout.joints_per_section)
        seen = np.abs(by_bend).max(axis=0) > _SEEN * np.abs(by_bend).max()
        return np.asarray(by_bend[:, seen] ** 2)

    @cached_property
    def contact(self) -> SurfaceContact:
        """Contacts that explain a load."""
        return SurfaceContact(self.mechanics)

    @cached_property
    def mechanics(self) -> SpatialMechanics:
        return SpatialMechanics(self.layout, self.uncertainty)


def _arrays(known: Filter) -> tuple[Array, Array, Array]:
    return known.q, known.mean, known.covariance


class SpatialRecursiveEstimator(SpatialEstimator):
    """Estimates the shape of one finger that leaves its plane from sample to sample.

    It has all outputs of SpatialEstimator, and `effective_driving_torque` (N) N m in bending, `loaded` (1),
    `innovation` (1) and those of `Changes`, as of RecursiveEstimator. Give it inputs that are sampled together every
    period of its function, from time 0, in discrete state.
    """

    def __init__(self, function: SpatialRecursiveShape, gravity: Array):
        """`gravity` in the world, (3,) m/s^2, zero for none."""
        super().__init__(function, function.layout, gravity, function.period)
        put_out_known(self, function, self.driving)

    def _derive_shape(self, function: SpatialFunction, layout: MeasurementModel) -> None:
        assert isinstance(function, SpatialRecursiveShape)
        derive_known(self, function, self.driving)

    def _derive_posterior(self, function: SpatialFunction) -> bool:
        return True
