"""Commands of an exported scenario over time: pressures, and positions of an arm without feedback of estimates.

A task that does not command the gripper moves the arm at fixed times, so that its motion is known before the run. A PD
controller of another simulator takes a position alone: the desired velocity and the weight of the arm are folded in.
"""

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from pydrake.multibody.tree import Joint, JointActuator

from soft_gripper.arrays import Array
from soft_gripper.diagrams.arm import Arm
from soft_gripper.diagrams.scene import arm_joints
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.drive import PATH_SEPARATOR, steps_of
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import Scenario


class CommandSchedule(NamedTuple):
    """Commands held from K times on, for C chambers and the n joints of an arm."""

    times: Array  # (K,) s; the run ends at the last one
    pressures: Array  # (K, C) Pa, effective: after the laws of the chambers
    arm: Array  # (K, k) rad or m, of the joints that follow no other


class ArmActuator(NamedTuple):
    """A joint of an arm and its PD controller."""

    joint: Joint
    stiffness: float  # N m/rad or N/m
    damping: float  # N m s/rad or N s/m
    effort: float  # largest, N m or N; may be infinite


def arm_actuators(station: Station) -> list[ArmActuator]:
    """Actuators of the arm, if any, in the order of its independent joints."""
    arm = station.parts.arm
    plant = station.plant
    if arm is None:
        return []
    actuators = map(plant.get_joint_actuator, plant.GetJointActuatorIndices(arm.model))
    joint_actuators: dict[int, JointActuator] = {int(actuator.joint().index()): actuator for actuator in actuators}
    joints = arm_joints(plant, arm.model)
    leader_actuators = [joint_actuators[int(joints[i].index())] for i in arm.couplings.leads]
    gains = [actuator.get_controller_gains() for actuator in leader_actuators]
    return [ArmActuator(a.joint(), g.p, g.d, a.effort_limit()) for a, g in zip(leader_actuators, gains, strict=True)]


def chamber_names(finger: PlantFinger) -> list[str]:
    """The chambers of a finger: `finger`, or `finger::chamber` if it has several."""
    labels = [
        f"{finger.name}{PATH_SEPARATOR}{label}" for names in finger.finger.chamber_axis.values() for label in names
    ]
    return labels or [finger.name] * finger.finger.pressures


def make_commands(station: Station) -> CommandSchedule:
    """The commands of a station over time."""
    scenario = station.scenario
    arm = station.parts.arm
    moves, desired = _motion(station)
    starts = np.arange(scenario.steps) * scenario.step_duration
    end = max(moves[-1], 0.0 if _has_fixed_motion(scenario) else scenario.steps * scenario.step_duration)
    times = np.unique([*starts[starts < end], *moves[moves < end], end])
    step, sample = (np.searchsorted(begins, times + 1e-9, side="right") - 1 for begins in (starts, moves))
    pressures = np.concatenate([_pressures(scenario, finger)[step] for finger in station.fingers], axis=1)
    positions = np.zeros((len(moves), 0)) if arm is None else _position_commands(arm, arm_actuators(station), desired)
    return CommandSchedule(times, pressures, positions[sample])


def _has_fixed_motion(scenario: Scenario) -> bool:
    return scenario.task is not None and not scenario.task.grips


def _motion(station: Station) -> tuple[Array, Array]:
    """Times, s, and the desired states of the arm from then on, (K, 2 n)."""
    arm = station.parts.arm
    task = station.task
    if task is not None and _has_fixed_motion(station.scenario):
        samples = list(task.unobserved_motion(station.scenario.duration))
        return np.array([time for time, _ in samples]), np.array([state for _, state in samples])
    home_state = [] if arm is None else [*arm.home, *np.zeros(len(arm.home))]
    return np.zeros(1), np.array([home_state])


def _position_commands(arm: Arm, actuators: Sequence[ArmActuator], desired: Array) -> Array:
    """Positions (K, k) with which PD controllers without desired velocity follow the motion and carry the weight."""
    positions, velocities = np.split(desired, 2, axis=1)
    leads = arm.couplings.leads
    stiffness, damping = (
        np.array([getattr(actuator, gain) for actuator in actuators]) for gain in ("stiffness", "damping")
    )
    context = arm.plant.CreateDefaultContext()
    weights = []
    for posture in positions:
        arm.plant.SetPositions(context, posture)
        weights.append(arm.plant.CalcGravityGeneralizedForces(context))
    weight_efforts = arm.couplings.leader_efforts(np.array(weights))
    return positions[:, leads] + (damping * velocities[:, leads] - weight_efforts[:, leads]) / stiffness


def _pressures(scenario: Scenario, finger: PlantFinger) -> Array:
    """Effective pressures of a finger at each step, (steps, C) Pa; 0 in a closed loop."""
    chamber_count = finger.finger.pressures
    if scenario.control.set_points is not None or not chamber_count:
        return np.zeros((scenario.steps, chamber_count))
    labels = [label for names in finger.finger.chamber_axis.values() for label in names]
    steps = steps_of("pressure", scenario.pressure.steps, finger.name, labels)
    step_pressures = steps[np.minimum(np.arange(scenario.steps), len(steps) - 1)]
    return finger.finger.effective_pressure(step_pressures)


def table(names: Sequence[str], commands: CommandSchedule) -> str:
    """The commands as CSV, in full precision; `names` are those of the chambers and then of the arm's joints."""
    rows = np.column_stack([commands.times, commands.pressures, commands.arm])
    lines = chain([["time [s]", *names]], ([repr(float(value)) for value in row] for row in rows))
    return "\n".join(map(",".join, lines)) + "\n"
