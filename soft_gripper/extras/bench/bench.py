"""Bench: the estimators and the grip controller of a station, without its plant, one sample at a time."""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from time import monotonic, thread_time
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import PassThrough

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.control.pid_controller import PidController
from soft_gripper.diagrams.commanding import grip_supply
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.wiring.drive import Commands
from soft_gripper.diagrams.wiring.estimation import add_estimations
from soft_gripper.diagrams.wiring.grip_control import add_grip_control, add_set_points, find_gripper, forms_gripper
from soft_gripper.diagrams.wiring.named_wires import Ports
from soft_gripper.diagrams.wiring.sensing import add_object_width
from soft_gripper.errors import InputError
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.plane import to_base
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import free_readings
from soft_gripper.extras.hardware.measured import SI
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.base_pose import AXES, UNITS, FixedBasePose
from soft_gripper.sensors.measurement import MeasurementModel

SET_POINT = "grip.set_point"
_COST_SAMPLES = 40  # samples whose cost is measured
_COST_BENDS = (0.0, 0.02, 0.05, 0.08)  # rad at every joint in these samples
_UPRIGHT_POSE = np.eye(3, 4).ravel()


class HeldInput(ArrayBlock):
    """Source of values from outside, held for a period.

    ::

        u (n) ---> HeldInput ---> y (n)
    """

    def __init__(self, period: float, size: int, unit: str | Sequence[str], **axes: Sequence[Any]):
        """Samples every `period` s, beginning at initialization; unit and axes as for `describe`."""
        super().__init__(period)
        self.take("u", size)
        self.sample("sampled", "u")
        self.put_out("y", lambda sampled: sampled, "sampled", unit=unit, **axes)


@dataclass
class _BenchParts:
    """Blocks of a bench in a diagram."""

    builder: DiagramBuilder
    period: float
    inputs: dict[str, int] = field(default_factory=dict)  # sizes, by name
    layouts: dict[str, MeasurementModel] = field(default_factory=dict)  # nominal, by finger
    measured: list[str] = field(default_factory=list)  # signals that are inputs
    signals: Ports = field(default_factory=dict)

    def hold(self, name: str, block: HeldInput) -> OutputPort:
        """Adds an input of the bench, constant for a period."""
        self.builder.AddNamedSystem(f"{name}.held", block)
        self.builder.ExportInput(block.get_input_port(), name)
        self.inputs[name] = block.get_input_port().size()
        return block.get_output_port()


class Cost(NamedTuple):
    """Cost of a sample, s."""

    processor: float  # s, 90th percentile
    elapsed: float  # s by the clock, mean; larger if other programs use the processor


class Bench:
    """Computes the signals of a station from measurements, in a separate Drake diagram.

    ::

        {finger}.strain (R) ------------> +-------+ ---> {finger}.estimated_joint_angles, tip_pose, external_torque ...
        {finger}.pressure (C) Pa -------> | Bench | ---> grip.opening, torque, force
        {finger}.tension (T) N ---------> |       | ---> {finger}.pressure_command  (C) Pa, in closed loop
        {finger}.X_WB (12) -------------> +-------+ ---> {finger}.measured_force  (2) N, m
    {finger}.measured_force (2) N, m -----^
        grip.set_point (1) m ---------------^

    The blocks are those of `add_estimation` and `add_grip_control`, so from the readings of a simulation they compute
    its signals to the last bit. Sensors of another kind name their input after their quantity.
    `X_WB` is an input of fingers that move; `grip.set_point` one where the scenario has `external: [opening]`;
    `measured_force`, `measured_torque` and `measured_angle`, value and place, those of instruments, held for a record.
    """

    def __init__(self, scenario: Scenario, moving: Sequence[str] = (), instruments: Sequence[str] = ()):
        """
        Args:
            scenario: its sensors, estimators, nominal model and control are used; nothing of it is simulated.
            moving: names of the fingers whose base moves, and is measured.
            instruments: `{finger}.measured_force` and so on, of those that are recorded beside the estimates.

        Raises:
            InputError: if a part of the scenario cannot be built, or needs a simulation.
        """
        self.scenario, self.period = bench_scenario(scenario), scenario.sensor.period
        parts = _make_parts(self.scenario, moving)
        for name in instruments:
            _add_instrument(parts, name)
        self.inputs, self.signals = parts.inputs, parts.signals
        self.layouts, self.measured = parts.layouts, parts.measured
        self._mechanics = {name: Mechanics(layout, Uncertainty()) for name, layout in parts.layouts.items()}
        for name, signal in parts.signals.items():
            parts.builder.ExportOutput(signal, name)
        self.diagram = parts.builder.Build()
        self._ports = {name: self.diagram.GetInputPort(name) for name in self.inputs}
        self._outputs = {name: self.diagram.GetOutputPort(name) for name in self.signals}
        self._controllers = _controllers(self.diagram)
        self.quantities = {name: f"{name}.{layout.quantity}" for name, layout in parts.layouts.items()}
        self._missing = {name: np.full(self.inputs[name], np.nan) for name in self.quantities.values()}
        self._begin()

    def _begin(self) -> None:
        self._simulator, self._samples, self._has_jumped = Simulator(self.diagram), 0, False
        self._context = self._simulator.get_mutable_context()
        self._give({name: np.zeros(size) for name, size in self.inputs.items()})

    def cost(self, signals: Sequence[str]) -> Cost:
        """Measures the cost of a sample and of reading these signals, with bent fingers, in a separate context."""
        copied = copy(self)
        times = []
        copied._begin()
        for i in range(_COST_SAMPLES):
            readings = {
                self.quantities[name]: layout.read(layout.straight + _COST_BENDS[i % len(_COST_BENDS)])
                for name, layout in self.layouts.items()
            }
            poses = {name: _UPRIGHT_POSE for name in self.inputs if name.endswith(".X_WB")}
            cpu_begin, elapsed = thread_time(), monotonic()
            copied.step(readings | poses)
            copied.read(signals)
            times.append((thread_time() - cpu_begin, monotonic() - elapsed))
        processor, elapsed = np.transpose(times[_COST_SAMPLES // 4 :])
        return Cost(float(np.quantile(processor, 0.9)), float(np.mean(elapsed)))

    def step(self, measurements: Mapping[str, Array]) -> None:
        """Takes a sample, a period after that before; `measurements` has every input by name."""
        self._give(measurements)
        self._advance()

    def skip(self) -> None:
        """Takes a missing sample: no sensor was read, and the drive is as before."""
        self._give(self._missing)
        self._advance()

    def pass_over(self, samples: int) -> None:
        """Lets the time of some samples pass without computing; estimators and control do not notice."""
        if self._samples and samples:
            self._samples = self._samples + samples
            self._has_jumped = True

    def restart_control(self) -> None:
        """Restarts the grip controller, after others have commanded the fingers."""
        self._restart(self._controllers)

    def restart_estimation(self) -> None:
        """Restarts the estimators after their sensors were zeroed, because they learned from other readings."""
        self._restart([system for system in self.diagram.GetSystems() if system.get_name().endswith(".estimation")])

    def _restart(self, systems: Iterable[System]) -> None:
        for system in systems:
            system.SetDefaultContext(system.GetMyMutableContextFromRoot(self._context))

    def read(self, signals: Sequence[str]) -> dict[str, Array]:
        """Reads signals at the last sample, (size,) each."""
        return {name: self._outputs[name].Eval(self._context) for name in signals}

    def free_readings(self) -> dict[str, Array]:
        """Readings that fingers at rest without contact would have at the last sample, by input.

        Raises:
            InputError: if a finger leaves its plane.
        """
        return {self.quantities[name]: self._free_reading(name, layout) for name, layout in self.layouts.items()}

    def _free_reading(self, name: str, layout: MeasurementModel) -> Array:
        if tuple(layout.deformations) != ("bending",):
            expected = "are zeroed only if they bend in one plane; calibrate this one instead"
            raise InputError(f"finger '{name}'", "deformations", ", ".join(layout.deformations), expected)
        driving, X_WB = self.read([f"{name}.{DRIVING_TORQUE}", f"{name}.X_WB"]).values()
        return free_readings(self._mechanics[name], driving, to_base(X_WB, np.array(self.scenario.gravity)))

    def _give(self, values: Mapping[str, Array]) -> None:
        for name, value in values.items():
            self._ports[name].FixValue(self._context, value)

    def _advance(self) -> None:
        if self._samples == 0:
            self._simulator.Initialize()  # from the first reading on, as sensors do
        elif self._has_jumped:
            self._context.SetTime(self._samples * self.period)
            self._simulator.Initialize(InitializeParams(suppress_initialization_events=True))
            self._has_jumped = False
        else:
            self._simulator.AdvanceTo(self._samples * self.period)
        self._simulator.AdvancePendingEvents()
        self._samples += 1


def _controllers(diagram: Diagram) -> list[PidController]:
    if not diagram.HasSubsystemNamed("grip_control"):
        return []
    systems = diagram.GetSubsystemByName("grip_control").GetSystems()
    return [system for system in systems if isinstance(system, PidController)]


def bench_scenario(scenario: Scenario) -> Scenario:
    """A scenario that may run on a bench, checked.

    Raises:
        InputError: if it may not.
    """
    scenario = checked_scenario("scenario", scenario)
    if scenario.task is not None and scenario.task.grips:
        expected = "may not command the gripper of a bench: give control.set_points, or external: [opening], instead"
        raise InputError("scenario", "task.phases", "with openings", expected)
    return scenario


def _make_parts(scenario: Scenario, moving: Sequence[str]) -> _BenchParts:
    scene = add_plant(DiagramBuilder(), scenario, visuals=False)
    if not scene.fingers:
        raise InputError("scenario", "models", [m.file for m in scenario.models], "there is no <finger> in them")
    parts = _BenchParts(DiagramBuilder(), scenario.sensor.period)
    nominal = read_nominal_model(scenario.nominal)
    gravity = np.array(scenario.gravity)
    finger_ports = {}
    for finger in scene.fingers:
        parts.layouts[finger.name] = nominal.layout(finger.finger, scenario.sensor)
        finger_ports[finger.name] = _add_measured(parts, finger, finger.name in moving)
    estimated = add_estimations(
        parts.builder, parts.layouts, scenario.estimator, scenario.sensor, gravity, finger_ports
    )
    for name, ports in estimated.items():
        parts.signals |= {f"{name}.{signal}": port for signal, port in {**finger_ports[name], **ports}.items()}
        held_signals = (signal for signal in finger_ports[name] if signal != "X_WB" or f"{name}.X_WB" in parts.inputs)
        parts.measured += [f"{name}.{signal}" for signal in held_signals]
    if forms_gripper(scene.fingers):
        _add_grip(parts, scene.fingers, scenario)
    return parts


def _add_measured(parts: _BenchParts, finger: PlantFinger, is_moving: bool) -> Ports:
    """Measurements of a finger, held for a period."""
    name = finger.name
    parameters = finger.finger
    layout = parts.layouts[finger.name]
    readings = HeldInput(parts.period, layout.readings, layout.unit, **layout.axes)
    inputs = {layout.quantity: parts.hold(f"{name}.{layout.quantity}", readings)}
    if parameters.pressures:
        block = HeldInput(parts.period, parameters.pressures, "Pa", **parameters.chamber_axis)
        inputs["sampled_pressure"] = parts.hold(f"{name}.pressure", block)
    if parameters.tendons:
        block = HeldInput(parts.period, len(parameters.tendons), "N", **parameters.tendon_axis)
        inputs["sampled_tension"] = parts.hold(f"{name}.tension", block)
    if is_moving:
        inputs["X_WB"] = parts.hold(f"{name}.X_WB", HeldInput(parts.period, 12, UNITS, **AXES))
    else:
        base = parts.builder.AddNamedSystem(f"{name}.base_pose", FixedBasePose(finger.X_WB))
        inputs["X_WB"] = base.get_output_port()
    return inputs


def _add_instrument(parts: _BenchParts, name: str) -> None:
    """Adds the value of an instrument and its location along the finger, which no block reads."""
    unit = SI[name.rpartition(".measured_")[2]]
    block = HeldInput(parts.period, 2, (unit, "m"), instrument=("value", "place"))
    parts.signals[name] = parts.hold(name, block)
    parts.measured.append(name)


def _add_grip(parts: _BenchParts, fingers: Sequence[PlantFinger], scenario: Scenario) -> None:
    """Adds the width of the held object, if contact is detected, and grip control, if the scenario closes the loop."""
    if scenario.estimator.contact_threshold is not None:
        gripper = find_gripper(fingers, "estimator.contact_threshold")
        nominal = {name: layout.finger for name, layout in parts.layouts.items()}
        parts.signals["grip.object_width"] = add_object_width(parts.builder, gripper, nominal, parts.signals)
    if scenario.control.set_points is None and "opening" not in scenario.external:
        return
    has_tendons_only = all(finger.finger.tendons and not finger.finger.pressures for finger in fingers)
    supply = grip_supply(scenario, fingers, "tendons" if has_tendons_only else "pressure")
    commands = _commands(parts.builder, fingers, scenario.tendons.command if has_tendons_only else "pressure")
    set_point, signals = add_grip_control(parts.builder, fingers, scenario.control, supply, parts.signals, commands)
    parts.signals |= signals
    if "opening" in scenario.external:
        set_input = parts.hold(SET_POINT, HeldInput(parts.period, 1, "m"))
        parts.builder.Connect(set_input, set_point)
        parts.signals[SET_POINT] = set_input
        parts.measured.append(SET_POINT)
    else:
        parts.signals |= add_set_points(parts.builder, set_point, scenario.control, parts.period)


def _commands(builder: DiagramBuilder, fingers: Sequence[PlantFinger], kind: str) -> Commands:
    """Ports for the commands of grip control, which drive nothing here."""
    commands = Commands(kind, {"pressure": "Pa", "tension": "N", "pull": "m"}[kind], {}, {})
    for finger in fingers:
        model = finger.finger
        commands.axes[finger.name] = model.chamber_axis if kind == "pressure" else model.tendon_axis
        pass_through = PassThrough(model.pressures if kind == "pressure" else len(model.tendons))
        commands.inputs[finger.name] = builder.AddNamedSystem(f"{finger.name}.commanded", pass_through).get_input_port()
    return commands
