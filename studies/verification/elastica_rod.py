"""Solves a bent finger pushed sideways in PyElastica: a Cosserat rod that comes to rest by damping."""

import elastica
import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers import Finger

_SHEAR_STIFFNESS = 5e3  # N, of stretch and shear: 7 µm of the tip
_DAMPING_RATE = 60.0  # 1/s, near the critical one of the slowest motion
_STEP_SHARE = 0.4  # of the longest that is stable
_DURATION = 1.0  # s; twice as long changes nothing that is printed


class _Rods(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):
    """The features of PyElastica in use, which it requires as base classes."""


def tip(finger: Finger, pressure: float, force: Array) -> Array:
    """Resting tip, (3,) m in B, of a finger with a constant section.

    PyElastica is of first order in the number of elements, since rest curvature is at inner nodes alone: extrapolated
    from 20 and 40.
    """
    coarse_tip, fine_tip = (_tip(finger, pressure, force, elements) for elements in (20, 40))
    return 2 * fine_tip - coarse_tip


def _tip(finger: Finger, pressure: float, force: Array, elements: int) -> Array:
    section, rods = finger.base, _Rods()
    area = float(section.area)
    rod = elastica.CosseratRod.straight_rod(
        n_elements=elements,
        start=np.zeros(3),
        direction=np.array([0.0, 0.0, 1.0]),
        normal=np.array([0.0, 1.0, 0.0]),
        base_length=finger.length,
        base_radius=np.sqrt(area / np.pi),
        density=float(section.density),
        youngs_modulus=float(section.youngs_modulus),
    )
    stiffness = section.bending_stiffness, section.sideways_stiffness, section.twist_stiffness  # about y, -x and z
    for axis, value in enumerate(stiffness):
        rod.bend_matrix[axis, axis] = float(value)
        rod.shear_matrix[axis, axis] = _SHEAR_STIFFNESS
    torque = float(section.chamber_area * section.chamber_eccentricity) * pressure
    rod.rest_kappa[0] = torque / float(section.bending_stiffness)
    step = _STEP_SHARE * finger.length / elements / np.sqrt(_SHEAR_STIFFNESS / (float(section.density) * area))
    rods.append(rod)
    rods.constrain(rod).using(elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    rods.add_forcing_to(rod).using(elastica.EndpointForces, np.zeros(3), np.asarray(force), ramp_up_time=0.2)
    rods.dampen(rod).using(elastica.AnalyticalLinearDamper, uniform_damping_constant=_DAMPING_RATE, time_step=step)
    rods.finalize()
    stepper, time = elastica.PositionVerlet(), np.float64(0.0)
    for _ in range(round(_DURATION / step)):
        time = stepper.step(rods, time, np.float64(step))
    return np.array(rod.position_collection[:, -1])
