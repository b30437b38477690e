"""Commands, applied: the sources that move the gripper and the arm of a station."""

from pydrake.systems.framework import DiagramBuilder, InputPort

from soft_gripper.diagrams.arm import add_arm_control, add_home, make_arm
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.task import add_task, add_tool_target
from soft_gripper.diagrams.wiring.drive import Drive, add_pressure_steps, check_steps, pressure_steps
from soft_gripper.diagrams.wiring.external import add_external_joints, add_external_opening, add_external_pressures
from soft_gripper.diagrams.wiring.grip_control import add_grip_control, add_set_points
from soft_gripper.diagrams.wiring.plant_signals import describe_arm_state
from soft_gripper.scenario.schema import ArmConfig


def add_pressure_commands(builder: DiagramBuilder, station: StationParts, drive: Drive) -> InputPort | None:
    """Adds the pressure command: an input, grip control or steps; returns the input of the set point for a task.

    Raises:
        InputError: if pressures are missing or name an unknown finger, or the fingers do not form a gripper.
    """
    scenario, period = station.scenario, station.scenario.sensor.period
    check_steps(scenario.pressure, drive.commands)
    if "pressure" in scenario.external:
        station.leave_open(add_external_pressures(builder, drive.commands))
        return None
    for_task = scenario.task is not None and scenario.task.grips
    if scenario.control.set_points is None and not for_task and "opening" not in scenario.external:
        steps = {name: pressure_steps(scenario.pressure, name) for name in drive.commands}
        station.signals |= add_pressure_steps(builder, steps, scenario.step_duration, drive.commands)
        return None
    set_point, signals = add_grip_control(
        builder, station.fingers, scenario.control, scenario.pressure, period, station.signals, drive.commands
    )
    station.signals |= signals
    if for_task:
        return set_point
    if "opening" in scenario.external:
        station.leave_open(add_external_opening(builder, set_point))
    else:
        station.signals |= add_set_points(builder, set_point, scenario.control, period)
    return None


def add_arm(builder: DiagramBuilder, station: StationParts, config: ArmConfig, set_point: InputPort | None) -> None:
    """Adds the arm control and its command: a task, an input, or the home posture.

    Raises:
        InputError: if the arm does not carry the gripper, or cannot do the task.
    """
    scenario, period = station.scenario, station.scenario.sensor.period
    station.arm = arm = make_arm(station.plant, scenario.models, config, station.fingers)
    desired = add_arm_control(builder, station.plant, arm)
    if scenario.task is not None:
        ports = (station.signals[f"grip.{name}"] for name in ("opening", "torque"))
        grip = None if set_point is None else (set_point, *ports)
        station.task, signals = add_task(builder, scenario.task, scenario.models, arm, period, desired, grip)
        station.signals |= signals
    elif "joints" in scenario.external:
        station.leave_open(add_external_joints(builder, arm.name, desired))
    elif "tool" in scenario.external:
        station.leave_open(add_tool_target(builder, station.plant, arm, period, desired))
    else:
        station.signals[f"{arm.name}.desired_state"] = add_home(builder, arm, desired)
    owner = arm.name if scenario.task is None else "task"
    describe_arm_state(station.plant, arm.name, station.signals[f"{owner}.desired_state"])
