"""The shape under few contact forces, and these forces: what bends a finger most often is one thing that it touches.

Free bending under driving torque and weight, q_0, is taken out of the measured bends. Where what remains is as small as
noise and uncertainty make it, nothing is touched. Else the single force is looked for that explains it
(`single_force`); where that leaves more than noise and there are sections enough, several that press on one side
(`several_forces`). What the forces leave unexplained goes to the joints as `gaussian` shares it, so that every
measured bend is met. With fewer than two sections that read anything, the shape is that of `gaussian`, and the force
is unknown.

Force and place of a single contact from a curved shape: Rucker and Webster (2011, doi 10.1109/IROS.2011.6094526) for
continuum robots; from sparse readings: arXiv 2109.12469.
"""

from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from scipy.special import chdtri

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.gaussian import GaussianShape, condition, sections_of
from soft_gripper.estimators.several_forces import fit_several_forces
from soft_gripper.estimators.single_force import Bends, Fit, choose, fit_single_force, misfit, put
from soft_gripper.fingers.statics import gravity_torque
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ContactForce, ShapeEstimate
from soft_gripper.shape.section_bends import UNKNOWN, section_bends
from soft_gripper.shape.uncertainty import Uncertainty

_PASSES = 2  # under an elastic law, whose slope is first taken where the most probable shape is
_CHANCE = 1e-3  # that noise alone leaves more than what counts as noise


@dataclass(frozen=True)
class ContactShape:
    """The estimator `contact` of one finger; a ShapeFunction."""

    layout: SensorLayout
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, their covariance and the contact force; see ShapeFunction."""
        layout, finger, believed = self.layout, self.layout.finger, self.uncertainty
        gaussian = self._gaussian(readings, driving, gravity)
        theta, variance = section_bends(layout, readings, believed.any_reading).uncertain_by(believed.gain)
        weight = gravity_torque(finger, gaussian.q, np.asarray(gravity)[..., None])
        known, q = driving + weight, gaussian.q
        for _ in range(1 if finger.elastic_law is None else _PASSES):
            fit = explain(layout, self.uncertainty, q, self._unexplained(q, theta, variance, driving, weight))
            q = finger.angle(known + fit.torque)
        gain, _ = condition(layout, self._gaussian.prior(gaussian.q, driving), variance)
        q = q + (gain @ (theta - layout.sums(q))[..., None])[..., 0]
        return ShapeEstimate(q, gaussian.covariance, fit.contact)

    def _unexplained(self, q: Array, theta: Array, variance: Array, driving: Array, weight: Array) -> Bends:
        """What driving torque and weight, (..., N) N m, leave of the bends of the sections, about the shape q."""
        layout, compliance = self.layout, self._gaussian.compliance(q)
        free = q + compliance * (driving + weight - layout.finger.elastic_torque(q))
        of_model = sections_of(layout, self._gaussian.of_model(q, driving))
        return Bends(theta - layout.sums(free), of_model + variance[..., None] * np.eye(layout.sections), compliance)

    @cached_property
    def _gaussian(self) -> GaussianShape:
        return GaussianShape(self.layout, self.uncertainty)


def explain(layout: SensorLayout, uncertainty: Uncertainty, q: Array, bends: Bends) -> Fit:
    """The contact that explains best what driving torque and weight do not bend.

    NaN where fewer than two sections are read.

    Args:
        layout: sensors and finger as they are believed to be.
        uncertainty: says how large loads usually are.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
    """
    shape, finger = q.shape[:-1], layout.finger
    usual = float(uncertainty.load_pressure * finger.pressure_gain[0] / (finger.length / 2))
    fit = _explain(layout, *_flat(q, bends), usual)
    contact = ContactForce(*(values.reshape(shape) for values in fit.contact))
    return Fit(contact, fit.torque.reshape(q.shape), fit.misfit.reshape(shape))


def _explain(layout: SensorLayout, q: Array, bends: Bends, usual: float) -> Fit:
    """The same of K samples; `usual` is the size of a usual force, N."""
    sections = (np.diagonal(bends.covariance, axis1=-2, axis2=-1) < UNKNOWN / 2).sum(axis=-1)
    noise = _quantiles(layout.sections)
    remaining = misfit(bends.theta, np.linalg.inv(bends.covariance))
    nan = np.full(len(q), np.nan)
    unknown = Fit(ContactForce(nan, nan, nan, nan), np.zeros_like(q), remaining)
    if (sections < 2).all():
        return unknown
    fit = fit_single_force(layout, q, bends, usual)
    several = (sections > 2) & (fit.misfit > noise[np.maximum(sections - 2, 0)])
    several &= fit.contact.arc_length < layout.finger.length
    if several.any():
        part, side = Bends(*(values[several] for values in bends)), np.sign(fit.contact.force[several])
        fit = put(several, fit_several_forces(layout, q[several], part, side, usual), fit)
    free = Fit(ContactForce(np.zeros(len(q)), nan, fit.contact.force_std, nan), np.zeros_like(q), remaining)
    return choose(sections < 2, unknown, choose(remaining < noise[sections], free, fit))


def _flat(q: Array, bends: Bends) -> tuple[Array, Bends]:
    """The same with a single leading axis."""
    joints, count = q.shape[-1], bends.theta.shape[-1]
    compliance = np.broadcast_to(bends.compliance, q.shape).reshape(-1, joints)
    covariance = np.broadcast_to(bends.covariance, (*q.shape[:-1], count, count)).reshape(-1, count, count)
    return q.reshape(-1, joints), Bends(bends.theta.reshape(-1, count), covariance, compliance)


@cache
def _quantiles(most: int) -> Array:
    """The misfits that noise does not exceed, by the number of what is free, from 0 to `most`; of none, that of one."""
    quantiles: Array = chdtri(np.maximum(np.arange(most + 1), 1), _CHANCE)
    return quantiles
