"""The tasks in PyElastica: one Cosserat rod per finger. Only free fingers are covered."""

from time import process_time

import elastica
import numpy as np
from scipy.linalg import eigh

from soft_gripper.fingers import Finger
from studies.peers.sensing import sense
from studies.peers.task import PeerTask, PeerTrial, Run, Setting

_GRAVITY_DIRECTION = (0.0, 0.0, 1.0)  # a finger hangs: gravity pulls along z of its frame B


class _Rods(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):
    """The features of PyElastica in use, which it requires as base classes."""


def make_run(task: PeerTask, setting: Setting) -> Run:
    """Makes runs by rods that are built anew before each.

    Elements are the finger's links, so that nodes between them are its joints, of the same stiffness. Pressure is rest
    curvature. The rod stretches and shears as its rubber does. Its damping goes by mass, not by stiffness, and is that
    of the first mode; its mass lies on the axis.
    """
    if task.bodies:
        raise NotImplementedError("rods and what they touch are round in PyElastica")
    step, substeps = setting["step"], task.substeps(setting["step"])
    pressures, stepper = task.pressures(substeps), elastica.PositionVerlet()

    def run() -> PeerTrial:
        rods, fingers = _make_rods(task, step)
        # Rest curvatures per pressure, 1/(m Pa), (N,)
        bends = [finger.pressure_gain / finger.stiffness / finger.segment_length for finger in task.fingers]
        tips = np.zeros((len(pressures), len(fingers)), dtype=complex)
        angles = np.zeros((len(pressures), len(fingers), task.fingers[0].segments))
        time = np.float64(0.0)
        stepper.step(rods, time, np.float64(1e-12))  # compiles
        start = process_time()
        for sample, period in enumerate(pressures):
            for step_pressures in period:
                for rod, bend, pressure in zip(fingers, bends, step_pressures, strict=True):
                    rod.rest_kappa[0] = bend * pressure
                time = stepper.step(rods, time, np.float64(step))
            for number, rod in enumerate(fingers):
                x, _, z = rod.position_collection[:, -1]
                tips[sample, number] = z + 1j * x
            if task.sensed:
                angles[sample] = [rod.kappa[0] * rod.voronoi_dilatation * rod.rest_voronoi_lengths for rod in fingers]
        if task.sensed:
            sense(task, angles, pressures[:, -1])
        return PeerTrial(process_time() - start, tips, np.zeros((len(tips), 0)))

    return run


def _make_rods(task: PeerTask, step: float) -> tuple[_Rods, list[elastica.CosseratRod]]:
    rods, gravity = _Rods(), np.linalg.norm(task.scenario.gravity)
    fingers = [_make_rod(finger) for finger in task.fingers]
    for finger, rod in zip(task.fingers, fingers, strict=True):
        rods.append(rod)
        rods.constrain(rod).using(elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
        rods.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=gravity * np.array(_GRAVITY_DIRECTION))
        rods.dampen(rod).using(
            elastica.AnalyticalLinearDamper, uniform_damping_constant=_damping(finger), time_step=np.float64(step)
        )
    rods.finalize()
    return rods, fingers


def _make_rod(finger: Finger) -> elastica.CosseratRod:
    section = finger.section(finger.length / 2)
    area = float(section.width * section.thickness)
    positions = np.zeros((3, finger.segments + 2))
    positions[2] = finger.link_ends
    rod = elastica.CosseratRod.straight_rod(
        n_elements=finger.segments + 1,
        start=np.zeros(3),
        direction=np.array(_GRAVITY_DIRECTION),
        normal=np.array([0.0, 1.0, 0.0]),
        base_length=finger.length,
        base_radius=np.sqrt(area / np.pi),
        density=finger.link_masses.sum() / (area * finger.length),
        youngs_modulus=float(section.youngs_modulus),
        position=positions,
    )
    rod.bend_matrix[0, 0] = rod.bend_matrix[1, 1] = finger.stiffness * rod.rest_voronoi_lengths
    return rod


def _damping(finger: Finger) -> float:
    """Rate, 1/s, that damps the first mode of a finger as its relaxation time does."""
    first = eigh(np.diag(finger.stiffness), finger.mass_matrix(), eigvals_only=True)[0]
    return float(finger.relaxation_time * first)
