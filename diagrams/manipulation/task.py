"""The task of a scenario: planned before anything moves, then led by a TaskMachine."""

from collections.abc import Mapping, Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort

from soft_gripper.diagrams.grip_control import add_grip_control
from soft_gripper.diagrams.manipulation.arm import make_arm
from soft_gripper.diagrams.manipulation.arm_control import add_arm_control
from soft_gripper.diagrams.manipulation.task_plan import plan_phases
from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.task_machine import TaskMachine
from soft_gripper.task_phases import Rules


def add_task(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    fingers: Sequence[PlantFinger],
    commands: Mapping[str, InputPort],
    signals: Mapping[str, OutputPort],
) -> dict[str, OutputPort]:
    """Adds `task`, and the arm's control and `grip_control` that it leads; returns the signals.

    Raises:
        InputError: if a phase leads where the arm cannot go.
    """
    arm = make_arm(scenario, plant, fingers)
    rules = Rules(plan_phases(scenario, arm), scenario.task.grip_threshold, scenario.task.timeout)
    machine = builder.AddNamedSystem("task", TaskMachine(rules, scenario.sensor.period))
    desired_state = add_arm_control(builder, scenario, plant, arm)
    set_point, of_control = add_grip_control(builder, scenario, fingers, commands, signals)
    builder.Connect(of_control["grip.distance"], machine.GetInputPort("distance"))
    builder.Connect(of_control["grip.torque"], machine.GetInputPort("torque"))
    builder.Connect(machine.GetOutputPort("desired_state"), desired_state)
    builder.Connect(machine.GetOutputPort("set_point"), set_point)
    own = {f"task.{name}": machine.GetOutputPort(name) for name in ("phase", "outcome", "desired_state")}
    return {"grip.set_point": machine.GetOutputPort("set_point"), **of_control, **own}
