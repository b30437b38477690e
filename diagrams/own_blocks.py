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


class OwnBlock(NamedTuple):
    """A block made by a user function."""

    field: str  # field of the scenario that names the function
    name: str  # name of the function, "module:function"
    place: str  # the finger, or another prefix of its signals
    block: System
    runs: bool  # in the diagram, and not in the recording alone
    port: str  # its required output
    quantity: str  # quantity that the sensors of the finger measure

    def error(self, port: str, expected: str) -> InputError:
        """An error at one of its ports."""
        output = self.block.GetOutputPort(port)
        unit = " rad" if port == ANGLES else ""
        expected = f"{self.place}: output port '{port}', ({output.size()}){unit}, {expected}"
        return InputError("scenario", self.field, self.name, expected)


def own_blocks(station: Station) -> list[OwnBlock]:
    """The user blocks of a station, each after those that feed it."""
    found, parts = [], station.parts
    for plant_finger in station.fingers:
        finger = plant_finger.name
        quantity = sensor_layout(plant_finger.finger, station.scenario.sensor).quantity
        if is_own(parts.sensor):
            block = _inside(station, f"{finger}.sensors", "sensor")
            found.append(OwnBlock("sensor.type", parts.sensor, finger, *block, quantity, quantity))
        if is_own(parts.estimator):
            block = _inside(station, f"{finger}.estimation", "estimator")
            found.append(OwnBlock("estimator.type", parts.estimator, finger, *block, ANGLES, quantity))
        for kind in filter(is_own, station.scenario.estimator.alongside):
            block = _inside(station, f"{finger}.{label(kind)}.estimation", "estimator")
            found.append(OwnBlock("estimator.alongside", kind, f"{finger}.{label(kind)}", *block, ANGLES, quantity))
    return found


def _inside(station: Station, part: str, name: str) -> tuple[System, bool]:
    """A block of a part of a station, and whether it is in its diagram."""
    runs = part not in station.removed
    within = station.diagram.GetSubsystemByName(part) if runs else station.removed[part]
    assert isinstance(within, Diagram)
    return within.GetSubsystemByName(name), runs


def blamed(station: Station, context: Context, failure: BaseException) -> InputError | None:
    """A failure of a run, or of reading its logs, as an error of a user block; None if no user block caused it.

    Args:
        station: the station that failed.
        context: the context of its diagram, at the time of the failure.
        failure: the exception from Drake or from a block.
    """
    for own in (own for own in own_blocks(station) if own.runs):
        for port in vector_outputs(own.block):
            again = _failure_of(own, port, context)
            if again is not None and type(again) is type(failure):
                return own.error(port, _failed(context.get_time(), failure))
    return blamed_by_traceback(station, context.get_time(), failure)


def blamed_by_traceback(station: Station, time: float, failure: BaseException) -> InputError | None:
    """A failure at a time, s, as an error of the user block whose code raised it; None if there is none."""
    blocks = own_blocks(station)
    frames = list(_frames(failure))
    of_block = (own for own in blocks if any(frame.f_locals.get("self") is own.block for frame in frames))
    modules = {str(frame.f_globals.get("__name__")) for frame in frames}
    of_module = (own for own in blocks if module_of(own.name) in modules)
    at_fault = next(of_block, None) or next(of_module, None)  # in an update: no port is at fault
    return None if at_fault is None else at_fault.error(at_fault.port, _failed(time, failure))


def _failed(time: float, failure: BaseException) -> str:
    return f"failed at t = {time:.6g} s: {described(failure)}"


def _failure_of(own: OwnBlock, port: str, context: Context) -> BaseException | None:
    """The exception that a port raises in the current state."""
    try:
        own.block.GetOutputPort(port).Eval(own.block.GetMyContextFromRoot(context))
    except (Exception, SystemExit) as error:
        return error
    return None


def _frames(failure: BaseException) -> Iterator[FrameType]:
    """The functions in the traceback of a failure."""
    traceback = failure.__traceback__
    while traceback is not None:
        yield traceback.tb_frame
        traceback = traceback.tb_next


def check_values(blocks: Iterable[OwnBlock], recording: Recording) -> None:
    """Checks all outputs of user blocks in a run.

    An estimator may output NaN where a reading is NaN.

    Raises:
        InputError: if a reading or a joint angle is not finite, with the first time.
    """
    for own in blocks:
        name = f"{own.place}.{own.port}"
        finger = own.place.partition(".")[0]
        taken = f"{finger}.{usable(own.quantity)}"
        readings = recording[taken if taken in recording.data else f"{finger}.{own.quantity}"]
        if own.port == own.quantity:
            ideal = f"{own.place}.{IDEAL}{own.quantity}"
            name = ideal if ideal in recording.data else name
            is_excused = np.zeros(len(readings), dtype=bool)
        else:
            is_excused = np.asarray(np.isnan(_flat(readings.values)).any(axis=1))
        values = _flat(recording[name].values)
        wrong = ~np.isfinite(values) & ~(np.isnan(values) & is_excused[:, None])
        if wrong.any():
            sample, entry = np.argwhere(wrong)[0]
            time = float(recording["time"].values[sample])
            raise own.error(
                own.port, f"is {values[sample, entry]} in entry {entry} at t = {time:.6g} s; output finite numbers"
            )


def _flat(values: Array) -> Array:
    return values.reshape(len(values), -1)
