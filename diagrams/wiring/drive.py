"""The drive, applied: pressures, user-defined elastic laws and creep, as torques on the finger joints."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.fingers.creep import CreepTorque, PressureSoftening, Softened
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.pressure_drive import PressureDrive, pressure_torque_map
from soft_gripper.fingers.statics import elastic_law_block
from soft_gripper.scenario.schema import PressureConfig
from soft_gripper.signals import describe


@dataclass(frozen=True)
class Drive:
    """The inputs of the commanded pressures, and the resulting outputs."""

    commands: dict[str, InputPort]  # Pa, by finger name
    pressures: dict[str, OutputPort]  # Pa in the chambers, by finger name
    actuations: dict[str, OutputPort]  # N m of all actuators, by model name


def add_pressure_drive(
    builder: DiagramBuilder, fingers: Sequence[PlantFinger], config: PressureConfig | None = None
) -> Drive:
    """Adds `{model}.pressure_drive` for each model with fingers, and connects it to the actuators.

    Args:
        builder: builder of a diagram with the fingers' plant. A finger with an elastic law gets a
            `{finger}.elastic_law`, one that creeps a `{finger}.creep`; with a pressure law, this is between
            `{finger}.unsoftened` and `{finger}.softened`, which `{finger}.softening` feeds.
        fingers: fingers in the finalized plant; all those of a model.
        config: the `pressure` part of a scenario, whose limits and lag are used; None: the defaults.

    Raises:
        InputError: if the step of a discrete plant is too long for a finger.
    """
    drive, config = Drive({}, {}, {}), config or PressureConfig()
    check_finalized(fingers)
    for finger in fingers:
        _check_time_step(finger)
    for model in dict.fromkeys(finger.model for finger in fingers):
        driven = [finger for finger in fingers if finger.model == model]
        if builder.IsConnectedOrExported(driven[0].plant.get_actuation_input_port(model)):
            expected = "already has a drive; give all fingers of a model in one call"
            raise InputError("add_pressure_drive", "model", driven[0].model_name, expected)
        block = _add_block(builder, driven, config)
        for name in (finger.name for finger in driven):
            drive.commands[name] = block.GetInputPort(f"{name}.pressure_command")
            drive.pressures[name] = block.GetOutputPort(f"{name}.pressure")
        elastic = [_add_elastic_law(builder, finger) for finger in driven if finger.finger.elastic_law is not None]
        creep = [_add_creep(builder, finger, drive.pressures[finger.name]) for finger in driven if finger.finger.creep]
        torques = [block.GetOutputPort("actuation"), *elastic, *creep]
        if any(finger.has_implicit_springs for finger in driven):
            _hold_straight(builder, driven[0])
        drive.actuations[driven[0].model_name] = _actuate(builder, driven[0], torques)
    return drive


def check_finalized(fingers: Sequence[PlantFinger]) -> None:
    """Raises an InputError if the plant of a finger is not finalized."""
    for finger in fingers:
        if not finger.plant.is_finalized():
            raise InputError("fingers", "plant", finger.name, "call plant.Finalize() before blocks are added")


def _check_time_step(finger: PlantFinger) -> None:
    limit, time_step = finger.finger.stable_time_step(), finger.plant.time_step()
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


def _add_block(builder: DiagramBuilder, driven: Sequence[PlantFinger], config: PressureConfig) -> PressureDrive:
    torque_maps = {finger.name: pressure_torque_map(finger) for finger in driven}
    time_step = driven[0].plant.time_step()
    laws = {finger.name: finger.finger.pressure_law for finger in driven}
    drive = PressureDrive(torque_maps, config.minimum, config.maximum, config.time_constant, time_step, laws)
    return builder.AddNamedSystem(f"{driven[0].model_name}.pressure_drive", drive)


def _hold_straight(builder: DiagramBuilder, finger: PlantFinger) -> None:
    """Gives the actuators that are springs of a model the straight finger as their desired state."""
    desired = finger.plant.get_desired_state_input_port(finger.model)
    rest = builder.AddNamedSystem(f"{finger.model_name}.straight", ConstantVectorSource(np.zeros(desired.size())))
    builder.Connect(rest.get_output_port(), desired)


def _add_elastic_law(builder: DiagramBuilder, finger: PlantFinger) -> OutputPort:
    """The torque that the elastic law adds to the linear springs of the finger, as actuation of its model."""
    angles = builder.AddNamedSystem(f"{finger.name}.bent_angles", MatrixGain(finger.position_selector()))
    law = builder.AddNamedSystem(f"{finger.name}.elastic_law", elastic_law_block(finger.finger))
    rows = np.ascontiguousarray(finger.actuator_selector().T)
    spread = builder.AddNamedSystem(f"{finger.name}.elastic_torque", MatrixGain(rows))
    builder.Connect(finger.plant.get_state_output_port(), angles.get_input_port())
    builder.Connect(angles.get_output_port(), law.get_input_port())
    builder.Connect(law.get_output_port(), spread.get_input_port())
    return spread.get_output_port()


def _add_creep(builder: DiagramBuilder, finger: PlantFinger, pressure: OutputPort) -> OutputPort:
    """The creep (memory) torque of the finger, as actuation of its model."""
    creep, state = CreepTorque(finger), finger.plant.get_state_output_port()
    builder.AddNamedSystem(f"{finger.name}.creep", creep)
    law = finger.finger.pressure_law
    if law is None:
        builder.Connect(state, creep.get_input_port())
        return creep.get_output_port()
    softening = builder.AddNamedSystem(f"{finger.name}.softening", PressureSoftening(law))
    unsoftened = builder.AddNamedSystem(f"{finger.name}.unsoftened", Softened(state.size(), divides=True))
    softened = builder.AddNamedSystem(
        f"{finger.name}.softened", Softened(creep.get_output_port().size(), divides=False)
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
    actuation, actuators = finger.plant.get_actuation_input_port(finger.model), finger.actuator_names
    if len(torques) == 1:
        builder.Connect(torques[0], actuation)
        return describe(torques[0], "N m", actuator=actuators)
    total = builder.AddNamedSystem(f"{finger.model_name}.actuation", Adder(len(torques), actuation.size()))
    for i, torque in enumerate(torques):
        builder.Connect(torque, total.get_input_port(i))
    builder.Connect(total.get_output_port(), actuation)
    return describe(total.get_output_port(), "N m", actuator=actuators)


COMMON = "all"


def pressure_steps(config: PressureConfig, finger: str) -> Array:
    """Pressure of a finger at each step, Pa, (steps,); a short list repeats its last value."""
    steps = config.steps.get(finger, config.steps.get(COMMON))
    if steps is None:
        known = ", ".join(config.steps)
        raise InputError("pressure", "steps", known, f"give steps for finger '{finger}' or for '{COMMON}'")
    return np.concatenate([steps, np.full(max(map(len, config.steps.values())) - len(steps), steps[-1])])


def check_steps(config: PressureConfig, fingers: Iterable[str]) -> None:
    """Raises an InputError if there are steps for a finger that is not in `fingers`."""
    known = [*fingers, COMMON]
    for name, steps in config.steps.items():
        if name not in known:
            raise InputError("pressure.steps", name, steps, f"no such finger; known: {', '.join(known)}")


def add_pressure_steps(
    builder: DiagramBuilder, steps: Mapping[str, Array], duration: float, commands: Mapping[str, InputPort]
) -> dict[str, OutputPort]:
    """Adds `{finger}.pressure_steps` for each command; returns the signals.

    `steps` are pressures by finger name, (steps,) Pa, each held for `duration` s.
    """
    signals = {}
    for finger, command in commands.items():
        source = builder.AddNamedSystem(f"{finger}.pressure_steps", step_source(steps[finger], duration))
        builder.Connect(source.get_output_port(), command)
        signals[f"{finger}.pressure_command"] = describe(source.get_output_port(), "Pa")
    return signals


def step_source(values: Array, duration: float) -> TrajectorySource:
    """A source that outputs each value in turn for `duration` s, then holds the last one."""
    times = np.arange(len(values) + 1) * duration
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.append(values, values[-1])[None, :]))
