"""Commands, applied: the sources that move the gripper and the arm of a station."""

from collections.abc import Sequence

from pydrake.systems.framework import DiagramBuilder, InputPort

from soft_gripper.diagrams.arm import add_arm_control, add_home, make_arm
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.task_plan import add_task, add_tool_target
from soft_gripper.diagrams.wiring.drive import (
    Drive,
    add_external_drive,
    add_input,
    add_steps,
    check_steps,
    check_stiffness,
)
from soft_gripper.diagrams.wiring.grip_control import Supply, add_grip_control, add_set_points
from soft_gripper.diagrams.wiring.plant_signals import describe_arm_state
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import ArmConfig, Scenario


def add_drive_commands(builder: DiagramBuilder, station: StationParts, drive: Drive) -> InputPort | None:
    """Adds the commands of pressures and tendons: inputs, grip control or steps; returns the set point's for a task.

    Raises:
        InputError: if commands are missing or name an unknown finger, or the fingers do not form a gripper.
    """
    scenario = station.scenario
    period = station.scenario.sensor.period
    steps = {"pressure": scenario.pressure.steps, "tendons": scenario.tendons.steps}
    drives = {"pressure": drive.pressure_commands, "tendons": drive.winch_commands}
    for part, commands in drives.items():
        check_steps(part, steps[part], commands)
    check_stiffness(station.fingers, scenario.pressure)
    if "pressure" in scenario.external:
        for commands in drives.values():
            station.leave_open(add_external_drive(builder, commands))
        return None
    for_task = scenario.task is not None and scenario.task.grips
    closes = scenario.control.set_points is not None or for_task or "opening" in scenario.external
    gripping = None if not closes else "tendons" if drive.tendon_commands and not drive.commands else "pressure"
    for part, commands in drives.items():
        if part != gripping:
            station.signals |= add_steps(builder, part, steps[part], scenario.step_duration, commands)
    if gripping is None:
        return None
    supply = grip_supply(scenario, station.fingers, gripping)
    set_point, signals = add_grip_control(
        builder, station.fingers, scenario.control, supply, station.signals, drives[gripping]
    )
    station.signals |= signals
    if for_task:
        return set_point
    if "opening" in scenario.external:
        station.leave_open(add_input(builder, "grip.set_point", set_point, "m"))
    else:
        station.signals |= add_set_points(builder, set_point, scenario.control, period)
    return None


def grip_supply(scenario: Scenario, gripper: Sequence[PlantFinger], gripping: str) -> Supply:
    """Supply that grip control may command: pressures or, of fingers without chambers, tensions or lengths of tendons.

    Negative commands of what only pushes, or pulls, go to the chambers, or tendons, that open the fingers.

    `gripping` is the part of the scenario that closes the fingers, "pressure" or "tendons".

    Raises:
        InputError: if the winches have no limit.
    """
    fingers = [finger.finger for finger in gripper]
    supply = scenario.pressure
    most = scenario.tendons.maximum
    period = scenario.sensor.period
    if gripping == "pressure" and all(finger.pressures == 1 for finger in fingers):
        return Supply(supply.minimum, supply.maximum, period)
    if gripping == "pressure":
        gains = [finger.pressure_gains for finger in fingers]
        most = supply.maximum
    else:
        gains = [finger.tension_gains for finger in fingers]
    if most is None:
        raise InputError("tendons", "maximum", None, "give it: grip control commands up to that")
    opens = any((torque_gains["bending"].sum(axis=-1) < 0).any() for torque_gains in gains)
    return Supply(-most if opens else 0.0, most, period)


def add_arm(builder: DiagramBuilder, station: StationParts, config: ArmConfig, set_point: InputPort | None) -> None:
    """Adds the arm control and its command: a task, an input, or the home posture.

    Raises:
        InputError: if the arm does not carry the gripper, or cannot do the task.
    """
    scenario = station.scenario
    period = station.scenario.sensor.period
    station.arm = arm = make_arm(station.plant, scenario.models, config, station.fingers)
    desired = add_arm_control(builder, station.plant, arm)
    if scenario.task is not None:
        ports = (station.signals[f"grip.{name}"] for name in ("opening", "torque"))
        grip = None if set_point is None else (set_point, *ports)
        station.task, signals = add_task(builder, scenario.task, scenario.models, arm, period, desired, grip)
        station.signals |= signals
    elif "joints" in scenario.external:
        station.leave_open(add_input(builder, f"{arm.name}.desired_state", desired))
    elif "tool" in scenario.external:
        station.leave_open(add_tool_target(builder, station.plant, arm, period, desired))
    else:
        station.signals[f"{arm.name}.desired_state"] = add_home(builder, arm, desired)
    owner = arm.name if scenario.task is None else "task"
    describe_arm_state(station.plant, arm.name, station.signals[f"{owner}.desired_state"])
