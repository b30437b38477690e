"""Errors of user blocks in a run, as one line: which function made the block, which port, and when."""

from collections.abc import Iterable, Iterator
from types import FrameType
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, Diagram, System

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.estimation import usable
from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.diagrams.wiring.sensors import IDEAL
from soft_gripper.errors import InputError, described
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.registry import is_own, label, module_of
from soft_gripper.scenario.sensor_presets import sensor_layout


class UserBlock(NamedTuple):
    """A block made by a user function."""

    field: str  # field of the scenario that names the function
    name: str  # name of the function, "module:function"
    prefix: str  # of its signals: the finger, or another
    system: System
    runs: bool  # in the diagram, not in the recording alone
    port: str  # its required output
    quantity: str  # quantity that the sensors of the finger measure

    def error(self, port: str, expected: str) -> InputError:
        """An error at one of its ports."""
        output = self.system.GetOutputPort(port)
        unit = " rad" if port == ANGLES else ""
        expected = f"{self.prefix}: output port '{port}', ({output.size()}){unit}, {expected}"
        return InputError("scenario", self.field, self.name, expected)


def user_blocks(station: Station) -> list[UserBlock]:
    """User blocks of a station, in the order of the data flow."""
    blocks = []
    for plant_finger in station.fingers:
        finger = plant_finger.name
        quantity = sensor_layout(plant_finger.finger, station.scenario.sensor).quantity
        if is_own(station.parts.sensor):
            block = _find_system(station, f"{finger}.sensors", "sensor")
            blocks.append(UserBlock("sensor.type", station.parts.sensor, finger, *block, quantity, quantity))
        estimators = [("estimator.type", station.parts.estimator, finger)]
        alongside = station.scenario.estimator.alongside
        estimators += [("estimator.alongside", kind, f"{finger}.{label(kind)}") for kind in alongside]
        for field, name, prefix in estimators:
            if is_own(name):
                block = _find_system(station, f"{prefix}.estimation", "estimator")
                blocks.append(UserBlock(field, name, prefix, *block, ANGLES, quantity))
    return blocks


def _find_system(station: Station, part: str, name: str) -> tuple[System, bool]:
    """Finds a block of a part of a station, and whether it is in the diagram."""
    runs = part not in station.removed
    part_diagram = station.diagram.GetSubsystemByName(part) if runs else station.removed[part]
    assert isinstance(part_diagram, Diagram)
    return part_diagram.GetSubsystemByName(name), runs


def user_block_error(station: Station, context: Context, failure: BaseException) -> InputError | None:
    """A failure of a run, or of reading its logs, as an error of a user block; None if no user block caused it."""
    for block in (block for block in user_blocks(station) if block.runs):
        for port in vector_outputs(block.system):
            error = _failure_of(block, port, context)
            if error is not None and type(error) is type(failure):
                return block.error(port, _failure_text(context.get_time(), failure))
    return blamed_by_traceback(station, context.get_time(), failure)


def blamed_by_traceback(station: Station, time: float, failure: BaseException) -> InputError | None:
    """A failure at a time, s, as an error of the user block whose code raised it; None if there is none."""
    blocks = user_blocks(station)
    frames = list(_frames(failure))
    running_blocks = (block for block in blocks if any(frame.f_locals.get("self") is block.system for frame in frames))
    modules = {str(frame.f_globals.get("__name__")) for frame in frames}
    module_blocks = (block for block in blocks if module_of(block.name) in modules)
    block_at_fault = next(running_blocks, None) or next(module_blocks, None)  # in an update: no port is at fault
    return None if block_at_fault is None else block_at_fault.error(block_at_fault.port, _failure_text(time, failure))


def _failure_text(time: float, failure: BaseException) -> str:
    return f"failed at t = {time:.6g} s: {described(failure)}"


def _failure_of(block: UserBlock, port: str, context: Context) -> BaseException | None:
    """The exception that a port raises in the current state."""
    try:
        block.system.GetOutputPort(port).Eval(block.system.GetMyContextFromRoot(context))
    except (Exception, SystemExit) as error:
        return error
    return None


def _frames(failure: BaseException) -> Iterator[FrameType]:
    """The functions in the traceback of a failure."""
    traceback = failure.__traceback__
    while traceback is not None:
        yield traceback.tb_frame
        traceback = traceback.tb_next


def check_values(blocks: Iterable[UserBlock], recording: Recording) -> None:
    """Checks all outputs of user blocks in a run.

    An estimator may output NaN where a reading is NaN.

    Raises:
        InputError: if a reading or a joint angle is not finite, with the first time.
    """
    for block in blocks:
        name = f"{block.prefix}.{block.port}"
        finger = block.prefix.partition(".")[0]
        usable_name = f"{finger}.{usable(block.quantity)}"
        readings = recording[usable_name if usable_name in recording.data else f"{finger}.{block.quantity}"]
        if block.port == block.quantity:
            ideal = f"{block.prefix}.{IDEAL}{block.quantity}"
            name = ideal if ideal in recording.data else name
            is_excused = np.zeros(len(readings), dtype=bool)
        else:
            is_excused = np.asarray(np.isnan(_flat(readings.values)).any(axis=1))
        values = _flat(recording[name].values)
        violations = ~np.isfinite(values) & ~(np.isnan(values) & is_excused[:, None])
        if violations.any():
            sample, entry = np.argwhere(violations)[0]
            time = float(recording["time"].values[sample])
            raise block.error(
                block.port, f"is {values[sample, entry]} in entry {entry} at t = {time:.6g} s; output finite numbers"
            )


def _flat(values: Array) -> Array:
    return values.reshape(len(values), -1)
