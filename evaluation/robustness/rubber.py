"""The moment of a section of rubber: what takes the place of E I times the curvature where strains are large.

A neo-Hookean silicone of the small-strain modulus E, stretched by lambda along the finger and free across it, has the
engineering stress

    sigma = E / 3 (lambda - 1 / lambda^2)

(Treloar, The Physics of Rubber Elasticity, 1975, ch. 4): it softens in tension and stiffens in compression. With plane
sections, lambda = 1 - kappa (x - x_n) at x, and the moment about the neutral axis x_n, which the strain-limiting layer
keeps in its place, is the integral of -sigma (x - x_n) over the section.
"""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.cross_section import CrossSection

_STRIPS = 400


def rubber_moment(section: CrossSection, curvature: Array) -> Array:
    """Bending moments, N m, at curvatures (...) 1/m, positive where the finger closes."""
    silicone = section.thickness - section.layer_thickness
    strip = silicone / _STRIPS
    x = -section.thickness / 2 + strip * (np.arange(_STRIPS) + 0.5)
    hollow = np.abs(x - section.chamber_center) < section.chamber_thickness / 2
    width, lever = section.width - hollow * section.chamber_width, x - section.neutral_axis
    stretch = 1 - curvature[..., None] * lever
    stress = section.youngs_modulus / 3 * (stretch - stretch**-2)
    off_axis = section.layer_center - section.neutral_axis
    of_layer = section.layer_thickness**2 / 12 + off_axis**2
    layer = section.layer_modulus * section.width * section.layer_thickness * of_layer
    moment: Array = -(stress * lever * width).sum(axis=-1) * strip + layer * curvature
    return moment
