"""The drive, applied: pressures, tendons, user-defined elastic laws and creep, as torques on the finger joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.math import BarycentricMesh
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, System
from pydrake.systems.primitives import (
    Adder,
    BarycentricMeshSystem,
    ConstantVectorSource,
    MatrixGain,
    PassThrough,
    Saturation,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.named_wires import Ports, add_stage
from soft_gripper.errors import InputError, suggestion
from soft_gripper.fingers.creep import CreepTorque, PressureSoftening, SoftenedProduct, shares
from soft_gripper.fingers.path_drive import BentChambers, TendonDrive
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.pressure_drive import PressureDrive, lag, pressure_torque_map
from soft_gripper.fingers.statics import elastic_law_block
from soft_gripper.fingers.taken_stiffness import TakenStiffness
from soft_gripper.run_begin import RunBegin
from soft_gripper.scenario.schema import PressureConfig, TendonConfig
from soft_gripper.signals import describe


@dataclass(frozen=True)
class Commands:
    """The inputs of the pressures, or of the tendons, of several fingers."""

    kind: str  # "pressure", "tension" or "pull"; signals are named {finger}.{kind}_command
    unit: str
    inputs: dict[str, InputPort]  # by finger name
    axes: dict[str, dict[str, list[str]]]  # labels of their entries, as for `describe`, by finger name

    def described(self, finger: str, port: OutputPort) -> OutputPort:
        """A port that carries the command of a finger, described."""
        return describe(port, self.unit, **self.axes[finger])


@dataclass(frozen=True)
class Drive:
    """The inputs of the commands, and the resulting outputs."""

    commands: dict[str, InputPort]  # (C) Pa, by finger name; of fingers with chambers
    tendon_commands: dict[str, InputPort]  # (T) N or m, by finger name; of fingers with tendons
    pressures: dict[str, OutputPort]  # (C) Pa in the chambers, by finger name
    tensions: dict[str, OutputPort]  # (T) N at the pulled ends of the tendons, by finger name
    actuations: dict[str, OutputPort]  # N m of all actuators, by model name
    pressure_commands: Commands  # of the pressures
    winch_commands: Commands  # of the tendons


def add_pressure_drive(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    config: PressureConfig | None = None,
    tendons: TendonConfig | None = None,
) -> Drive:
    """Adds `{model}.pressure_drive` for each model with fingers, and connects it to the actuators.

    Args:
        builder: builder of a diagram with the fingers' plant. A finger with tendons gets a `{finger}.tendons`, one
            whose chambers run aslant or twist a `{finger}.bent_chambers`, one with an elastic law a
            `{finger}.elastic_law`, one of whose stiffness pressure takes a part a `{finger}.taken_stiffness`, one that
            creeps a `{finger}.creep`; where a chamber widens, this is between `{finger}.unsoftened` and
            `{finger}.softened`, which `{finger}.softening` feeds.
        fingers: fingers in the finalized plant; all those of a model.
        config: the `pressure` part of a scenario, whose limits and lag are used; None: the defaults.
        tendons: the `tendons` part, likewise.

    Raises:
        InputError: if the step of a discrete plant is too long for a finger, or a tendon cannot be commanded so.
    """
    config, tendons = config or PressureConfig(), tendons or TendonConfig()
    _check_leaks(fingers, config)
    drive = _empty_drive(fingers, tendons.command)
    check_finalized(fingers)
    for finger in fingers:
        _check_time_step(finger)
    for model in dict.fromkeys(finger.model for finger in fingers):
        group = [finger for finger in fingers if finger.model == model]
        if builder.IsConnectedOrExported(group[0].plant.get_actuation_input_port(model)):
            expected = "already has a drive; give all fingers of a model in one call"
            raise InputError("add_pressure_drive", "model", group[0].model_name, expected)
        torques = _add_chambers(builder, [finger for finger in group if finger.finger.pressures], config, drive)
        for finger in group:
            if finger.finger.tendons:
                torques.append(_add_tendons(builder, finger, tendons, drive))
            if finger.finger.elastic_law is not None:
                torques.append(_add_elastic_law(builder, finger))
            if finger.finger.takes_stiffness:
                block = TakenStiffness(finger)
                torques.append(_add_shape_torque(builder, "taken_stiffness", block, drive, finger))
            if finger.finger.creep:
                torques.append(_add_creep(builder, finger, drive.pressures.get(finger.name)))
        if any(finger.has_implicit_springs for finger in group):
            _hold_straight(builder, group[0])
        drive.actuations[group[0].model_name] = _actuate(builder, group[0], torques)
    return drive


def _check_leaks(fingers: Sequence[PlantFinger], config: PressureConfig) -> None:
    """Raises an InputError if a leaking finger does not exist, or its pressure acts by its shape."""
    finger_names = [finger.name for finger in fingers if finger.finger.pressures and not _acts_by_shape(finger)]
    for name, fraction in config.leaks.items():
        if name not in (*finger_names, COMMON):
            raise InputError(
                "pressure.leaks", name, fraction, f"no such finger that can leak; {suggestion(name, finger_names)}"
            )


def _empty_drive(fingers: Sequence[PlantFinger], tendon_command: str) -> Drive:
    """A drive without ports yet."""
    pressure_commands = Commands(
        "pressure", "Pa", {}, {f.name: f.finger.chamber_axis for f in fingers if f.finger.pressures}
    )
    unit = "N" if tendon_command == "tension" else "m"
    axes = {f.name: f.finger.tendon_axis for f in fingers}
    winch_commands = Commands(tendon_command, unit, {}, {f.name: axes[f.name] for f in fingers if f.finger.tendons})
    return Drive(pressure_commands.inputs, winch_commands.inputs, {}, {}, {}, pressure_commands, winch_commands)


def _add_chambers(
    builder: DiagramBuilder, fingers: Sequence[PlantFinger], config: PressureConfig, drive: Drive
) -> list[OutputPort]:
    """The torques of the pressures of some fingers of a model; their ports become part of the drive."""
    if not fingers:
        return []
    block = _add_block(builder, fingers, config)
    for finger in fingers:
        drive.commands[finger.name] = block.GetInputPort(f"{finger.name}.pressure_command")
        pressure = drive.pressures[finger.name] = block.GetOutputPort(f"{finger.name}.pressure")
        describe(pressure, "Pa", **finger.finger.chamber_axis)
    turned = [finger for finger in fingers if chambers_turn(finger)]
    bent = [_add_shape_torque(builder, "bent_chambers", BentChambers(finger), drive, finger) for finger in turned]
    return [block.GetOutputPort("actuation"), *bent]


def _add_shape_torque(
    builder: DiagramBuilder, name: str, block: System, drive: Drive, finger: PlantFinger
) -> OutputPort:
    """Torque of the pressures that depends on the shape of a finger, as actuation of its model."""
    builder.AddNamedSystem(f"{finger.name}.{name}", block)
    builder.Connect(finger.plant.get_state_output_port(), block.GetInputPort("state"))
    builder.Connect(drive.pressures[finger.name], block.GetInputPort("pressure"))
    return block.GetOutputPort("actuation")


def _acts_by_shape(finger: PlantFinger) -> bool:
    """Whether the torque of a pressure depends on the shape of a finger, by the pressure that its sensor reads."""
    return chambers_turn(finger) or finger.finger.takes_stiffness


def chambers_turn(finger: PlantFinger) -> bool:
    """Whether the torque of the chambers depends on the shape of a finger."""
    is_slanted = not finger.finger.chamber_paths.are_parallel
    return bool(finger.finger.chambers) and (is_slanted or "twist" in finger.finger.yields)


def _add_tendons(builder: DiagramBuilder, finger: PlantFinger, config: TendonConfig, drive: Drive) -> OutputPort:
    """The torque of the tendons of a finger; their ports become part of the drive.

    Raises:
        InputError: if they are commanded in length, and one has no stiffness.
    """
    tendons = finger.finger.tendons
    for tendon in tendons:
        if config.command == "pull" and tendon.stiffness == 0:
            expected = f"tendon '{tendon.name}' of finger '{finger.name}' has no stiffness: give it, or command tension"
            raise InputError("tendons", "command", config.command, expected)
    count = len(tendons)
    block = builder.AddNamedSystem(f"{finger.name}.tendons", TendonDrive(finger, config.command))
    max_tensions = np.full(count, np.inf if config.maximum is None else config.maximum)
    limits = builder.AddNamedSystem(f"{finger.name}.tendon_limits", Saturation(np.zeros(count), max_tensions))
    command = limits.get_output_port()
    if config.time_constant > 0:
        winches = lag(config.time_constant, finger.plant.time_step(), count)
        command = add_stage(builder, f"{finger.name}.winches", winches, command)
    builder.Connect(finger.plant.get_state_output_port(), block.GetInputPort("state"))
    builder.Connect(command, block.GetInputPort(f"{config.command}_command"))
    drive.tendon_commands[finger.name] = limits.get_input_port()
    drive.tensions[finger.name] = block.GetOutputPort("tension")
    return block.GetOutputPort("actuation")


def check_finalized(fingers: Sequence[PlantFinger]) -> None:
    """Raises an InputError if the plant of a finger is not finalized."""
    for finger in fingers:
        if not finger.plant.is_finalized():
            raise InputError("fingers", "plant", finger.name, "call plant.Finalize() before blocks are added")


def _check_time_step(finger: PlantFinger) -> None:
    limit = finger.finger.stable_time_step()
    time_step = finger.plant.time_step()
    if finger.has_implicit_springs:
        _check_implicit(finger)
    elif time_step > limit:
        expected = (
            f"longer than stable_time_step() = {limit:.3g} s of finger '{finger.name}'; or 0 for cenic; or choose"
        )
        expected += " springs: implicit for its model"
        raise InputError("plant_config", "time_step", time_step, expected)


def _check_implicit(finger: PlantFinger) -> None:
    """Raises an InputError if something else about the finger is explicit, or the plant has no steps."""
    where = f"model '{finger.model_name}'"
    if finger.plant.time_step() == 0:
        raise InputError(where, "springs", "implicit", "needs a discrete plant: give plant_config.time_step")
    if finger.finger.elastic_law is not None:
        expected = f"finger '{finger.name}' has an elastic law, which is explicit: choose linear springs"
        raise InputError(where, "springs", "implicit", expected)


def _add_block(builder: DiagramBuilder, fingers: Sequence[PlantFinger], config: PressureConfig) -> PressureDrive:
    torque_maps = {finger.name: pressure_torque_map(finger) for finger in fingers}
    time_step = fingers[0].plant.time_step()
    laws = {finger.name: finger.finger.laws for finger in fingers}
    limits = config.minimum, config.maximum, config.time_constant
    leaks = (
        {name: config.leaks.get(name, config.leaks.get(COMMON, 0.0)) for name in torque_maps} if config.leaks else None
    )
    drive = PressureDrive(torque_maps, *limits, time_step, laws, leaks, config.leak_time)
    return builder.AddNamedSystem(f"{fingers[0].model_name}.pressure_drive", drive)


def _hold_straight(builder: DiagramBuilder, finger: PlantFinger) -> None:
    """Gives the actuators that are springs of a model the straight finger as their desired state."""
    desired = finger.plant.get_desired_state_input_port(finger.model)
    source = builder.AddNamedSystem(f"{finger.model_name}.straight", ConstantVectorSource(np.zeros(desired.size())))
    builder.Connect(source.get_output_port(), desired)


def _add_elastic_law(builder: DiagramBuilder, finger: PlantFinger) -> OutputPort:
    """The torque that the elastic law adds to the linear springs of the finger, as actuation of its model."""
    selector = MatrixGain(finger.position_selector())
    angles = add_stage(builder, f"{finger.name}.bent_angles", selector, finger.plant.get_state_output_port())
    torque = add_stage(builder, f"{finger.name}.elastic_law", elastic_law_block(finger.finger), angles)
    rows = np.ascontiguousarray(finger.actuator_selector().T)
    return add_stage(builder, f"{finger.name}.elastic_torque", MatrixGain(rows), torque)


def _add_creep(builder: DiagramBuilder, finger: PlantFinger, pressure: OutputPort | None) -> OutputPort:
    """The creep (memory) torque of the finger, as actuation of its model."""
    state = finger.plant.get_state_output_port()
    law = finger.finger.pressure_law
    if law is None or pressure is None or not law.widens:
        return add_stage(builder, f"{finger.name}.creep", CreepTorque(finger), state)
    creep = builder.AddNamedSystem(f"{finger.name}.creep", CreepTorque(finger))
    softening = builder.AddNamedSystem(f"{finger.name}.softening", PressureSoftening(law))
    unsoftened = builder.AddNamedSystem(f"{finger.name}.unsoftened", SoftenedProduct(state.size(), divides=True))
    softened = builder.AddNamedSystem(
        f"{finger.name}.softened", SoftenedProduct(creep.get_output_port().size(), divides=False)
    )
    builder.Connect(pressure, softening.get_input_port())
    for block in (unsoftened, softened):
        builder.Connect(softening.get_output_port(), block.GetInputPort("softening"))
    builder.Connect(state, unsoftened.GetInputPort("factor"))
    builder.Connect(unsoftened.get_output_port(), creep.get_input_port())
    builder.Connect(creep.get_output_port(), softened.GetInputPort("factor"))
    return softened.get_output_port()


def _actuate(builder: DiagramBuilder, finger: PlantFinger, torques: Sequence[OutputPort]) -> OutputPort:
    """Connects the sum of torques to the actuators of a finger's model; returns it."""
    actuation = finger.plant.get_actuation_input_port(finger.model)
    actuators = finger.actuator_names
    if len(torques) == 1:
        builder.Connect(torques[0], actuation)
        return describe(torques[0], "N m", actuator=actuators)
    total = builder.AddNamedSystem(f"{finger.model_name}.actuation", Adder(len(torques), actuation.size()))
    for i, torque in enumerate(torques):
        builder.Connect(torque, total.get_input_port(i))
    builder.Connect(total.get_output_port(), actuation)
    return describe(total.get_output_port(), "N m", actuator=actuators)


def check_stiffness(fingers: Sequence[PlantFinger], config: PressureConfig) -> None:
    """Raises an InputError if the supply could take all the stiffness of a finger that has crept: it would balloon."""
    pressures = np.linspace(config.minimum, config.maximum, _PRESSURE_LEVELS)
    for finger in (finger for finger in fingers if finger.finger.takes_stiffness):
        remains = 1 - shares(finger.finger).sum() - finger.finger.share_taken(pressures)
        if remains.min() <= 0:
            lowest = pressures[remains <= 0].min()
            expected = f"pressure_law and creep of finger '{finger.name}' leave no stiffness from {lowest:.3g} Pa on"
            raise InputError("pressure", "maximum", config.maximum, f"{expected}: stay within the fitted range")


COMMON = "all"  # key of a command to all fingers
PATH_SEPARATOR = "::"  # between a finger and its chamber or tendon
_PRESSURE_LEVELS = 1001  # of the pressure
Steps = Mapping[str, Sequence[float]]


def steps_of(where: str, steps: Steps, finger: str, paths: Sequence[str] = ()) -> Array:
    """Commands to a finger at each step, (steps, C); a short list repeats its last value.

    `steps` are those of each `finger::path`, of a `finger` or of all; `paths` names its chambers or tendons, if there
    are several; `where` is the part of the scenario, for messages.

    Raises:
        InputError: if there are none for it.
    """
    commands = []
    for path in paths or ("",):
        values = next((steps[n] for n in (f"{finger}{PATH_SEPARATOR}{path}", finger, COMMON) if n in steps), None)
        if values is None:
            step_names = ", ".join(steps)
            raise InputError(where, "steps", step_names, f"give steps for finger '{finger}' or for '{COMMON}'")
        commands.append(values)
    longest = max(map(len, steps.values()))
    return np.array([[*values, *[values[-1]] * (longest - len(values))] for values in commands]).T


def pressure_steps(config: PressureConfig, finger: str) -> Array:
    """Pressure of a finger with one chamber at each step, Pa, (steps,); see `steps_of`."""
    return steps_of("pressure", config.steps, finger)[:, 0]


def check_steps(where: str, steps: Steps, commands: Commands) -> None:
    """Raises an InputError if steps name a finger, a chamber or a tendon that does not exist."""
    paths = [
        f"{finger}{PATH_SEPARATOR}{name}"
        for finger, axes in commands.axes.items()
        for names in axes.values()
        for name in names
    ]
    valid_names = [*commands.axes, *paths, COMMON]
    for name, values in steps.items():
        if name not in valid_names:
            raise InputError(f"{where}.steps", name, values, f"no such finger; {suggestion(name, valid_names)}")


def add_steps(builder: DiagramBuilder, where: str, steps: Steps, duration: float, commands: Commands) -> Ports:
    """Adds `{kind}_steps`, if there are commands; returns the signals `{finger}.{kind}_command`.

    Each step is held for `duration` s; see `steps_of`.
    """
    values = {}
    for finger in commands.inputs:
        paths = [path for names in commands.axes[finger].values() for path in names]
        values[finger] = steps_of(where, steps, finger, paths)
    if not values:
        return {}
    source = builder.AddNamedSystem(f"{commands.kind}_steps", StepSource(values, duration))
    for finger, command in commands.inputs.items():
        builder.Connect(source.GetOutputPort(finger), command)
    return {
        f"{finger}.{commands.kind}_command": commands.described(finger, source.GetOutputPort(finger))
        for finger in values
    }


_STEP_TOLERANCE = 1e-9  # s before a step is due, by which the sum of sampling periods may fall short
_MAX_RUN_TIME = 1e9  # s, of any run


class StepSource(Diagram):
    """Outputs values in turn, each for the same time from the beginning of a run, then holds the last ones.

    ::

        time ------> elapsed ---> which step (steps), 1 and else 0 ---> {name} (C), for every name
        begin ---------^

    Nothing in it is written in Python, because the plant reads it at every step.
    """

    def __init__(self, values: Mapping[str, Array], duration: float):
        """`values` by name, (steps, C) each, of `duration` s each."""
        super().__init__()
        builder = DiagramBuilder()
        time = TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, _MAX_RUN_TIME], [[0.0, _MAX_RUN_TIME]]))
        elapsed = builder.AddNamedSystem("elapsed", Adder(2, 1))
        begin = builder.AddNamedSystem("begin", RunBegin())
        builder.Connect(builder.AddNamedSystem("time", time).get_output_port(), elapsed.get_input_port(0))
        builder.Connect(begin.get_output_port(), elapsed.get_input_port(1))
        mesh = BarycentricMeshSystem(*_step_mesh(len(next(iter(values.values()))), duration))
        step = add_stage(builder, "step", mesh, elapsed.get_output_port())
        for name, rows in values.items():
            value = add_stage(builder, name, MatrixGain(np.ascontiguousarray(rows.T)), step)
            builder.ExportOutput(value, name)
        builder.BuildInto(self)


def _step_mesh(steps: int, duration: float) -> tuple[BarycentricMesh, Array]:
    """Nodes in time, and at each node 1 for the step that lasts then and 0 for the others, (steps, nodes)."""
    changes = np.arange(1, steps) * duration - _STEP_TOLERANCE
    nodes = [0.0, *np.stack([changes - _STEP_TOLERANCE, changes], axis=-1).ravel(), steps * duration]
    return BarycentricMesh([set(nodes)]), np.repeat(np.eye(steps), 2, axis=1)


class External(NamedTuple):
    """The inputs of commands and the resulting signals, by name."""

    inputs: dict[str, InputPort]
    signals: dict[str, OutputPort]


def add_external_drive(builder: DiagramBuilder, commands: Commands) -> External:
    """Adds `{finger}.{kind}_command` for each command, such as `left_finger.pressure_command`, (C) Pa."""
    external = External({}, {})
    for finger, command in commands.inputs.items():
        added = add_input(builder, f"{finger}.{commands.kind}_command", command)
        external.inputs.update(added.inputs)
        external.signals.update({name: commands.described(finger, port) for name, port in added.signals.items()})
    return external


def add_input(builder: DiagramBuilder, name: str, target: InputPort, unit: str | None = None) -> External:
    """Adds an input of that name, in a unit, which commands `target`."""
    pass_through = builder.AddNamedSystem(name, PassThrough(target.size()))
    builder.Connect(pass_through.get_output_port(), target)
    signal = pass_through.get_output_port()
    return External({name: pass_through.get_input_port()}, {name: signal if unit is None else describe(signal, unit)})
