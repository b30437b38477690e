"""Observability of a finger: before anything is read, how well its sensors fix each of its deformations.

A section is described by how far it bends, turns sideways, twists and stretches as a whole, each shared equally by its
joints. With a weak prior of variances P and readings of independent noise sigma, which change by A with these numbers
about the straight finger,

    covariance = (P^-1 + A^T A / sigma^2)^-1 .

A deformation counts as observed where that makes its standard deviation much smaller than that of the prior.
"""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.sensors.measurement import MeasurementModel

_PRIOR_STD = {"bending": 1.0, "sideways": 0.5, "twist": 0.5, "stretch": 0.1}  # rad, and m over the length of a section
_OBSERVED_SHARE = 0.15  # of the prior's standard deviation


@dataclass(frozen=True)
class Observed:
    deformation: str
    std: Array  # (S,) rad, and m where joints slide, of the whole section; infinite: not observed

    @property
    def is_seen(self) -> bool:
        return bool(np.isfinite(self.std).all())

    def __str__(self) -> str:
        max_std = float(self.std.max())
        size = f"{1e3 * max_std:.2g} mm" if self.deformation in SLIDES else f"{np.degrees(max_std):.2g} degrees"
        return f"{self.deformation} to {size}" if self.is_seen else f"{self.deformation} not at all"


def observability(layout: MeasurementModel, noise: float) -> list[Observed]:
    """Standard deviations that sensors on a straight finger leave to each of its deformations.

    Args:
        layout: sensors and finger.
        noise: standard deviation of every reading, in the unit of what is measured.
    """
    prior, S = weak_prior(layout), layout.sections
    observed_space = layout.slopes(layout.straight) @ shared_equally(layout)
    std = np.sqrt(np.diag(np.linalg.inv(np.diag(1 / prior**2) + observed_space.T @ observed_space / noise**2)))
    observed_std = np.where(std < _OBSERVED_SHARE * prior, std, np.inf).reshape(-1, S)
    std_by_way = dict(zip(layout.deformations, observed_std, strict=True))
    deformations = [name for name in _PRIOR_STD if name in layout.finger.yields]
    return [Observed(name, std_by_way.get(name, np.full(S, np.inf))) for name in deformations]


def shared_equally(layout: MeasurementModel) -> Array:
    """Matrix from deformations of whole sections, one after another, to equal parts at their joints, (D, W S)."""
    is_in_section = layout.joint_sections[:, None] == np.arange(layout.sections)
    return np.kron(np.eye(len(layout.deformations)), is_in_section / layout.joints_per_section)


def weak_prior(layout: MeasurementModel) -> Array:
    """Prior standard deviations of deformations of whole sections, one after another, (W S,)."""
    ones = np.ones(layout.sections)
    stds = [_PRIOR_STD[name] * (layout.rest_lengths if name in SLIDES else ones) for name in layout.deformations]
    return np.concatenate(stds)
