"""Feeds a log of a finger with strain sensors, T samples, to the blocks of its estimation, without a plant.

If the sensors were set anew, their offsets are found again while the finger is free and at rest, where pressure and
weight balance: the mean difference from a free finger's readings there is subtracted from all.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.private_run import remove_unread_blocks
from soft_gripper.diagrams.recording import Recording, read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.diagrams.wiring.estimation import add_estimation
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.finger_logs import FingerLog, nominal_layout
from soft_gripper.extras.hardware.replay.arm_estimation import MAX_TIME, LogSource
from soft_gripper.files.document import require
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.base_pose import AXES, UNITS
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import strain_sensors


def sampled_rows(log: FingerLog, period: float) -> NDArray[np.int_]:
    """Indices of the rows of a log that hold at times `period` s apart, from its first on."""
    span = float(log.time[-1] - log.time[0])
    require(span <= MAX_TIME, log.name, "time", span, f"a run may take at most {MAX_TIME:g} s: is its unit right?")
    times = log.time[0] + period * np.arange(int(span / period) + 1)
    return np.searchsorted(log.time, times + 1e-6 * period, side="right") - 1


def estimate_log(log: FingerLog, scenario: Scenario, estimators: Sequence[str]) -> Recording:
    """Feeds the readings of a log to estimators, at the period of the scenario's sensors.

    The result has the signals of each estimation, `{estimator}.{signal}`, and the readings, pressures and poses; times
    begin at 0.
    """
    builder, period, model = DiagramBuilder(), scenario.sensor.period, log.finger.finger
    layout, rows = nominal_layout(scenario, log.finger), sampled_rows(log, period)
    sources: dict[str, tuple[Array, str | Sequence[str], Mapping[str, Sequence[Any]]]] = {
        layout.quantity: (log.readings, layout.unit, layout.axes),
        "sampled_pressure": (log.pressure[:, None], "Pa", model.chamber_axis),
        "X_WB": (log.X_WB.reshape(-1, 12), UNITS, AXES),
    }
    if model.pressures != 1 or model.tendons:
        field, count = f"chambers and tendons of {model.name}", model.pressures + len(model.tendons)
        raise InputError(log.name, field, count, "only a finger that one pressure bends is replayed")
    measured = {}
    for name, (samples, unit, axes) in sources.items():
        source = builder.AddNamedSystem(name, LogSource(name, samples[rows], period, unit, **axes))
        measured[name] = source.get_output_port()
    signals = dict(measured)
    for name in estimators:
        config = replace(scenario.estimator, type=name, alongside=[])
        ports = add_estimation(builder, name, layout, config, scenario.sensor, log.gravity, measured)
        signals |= {f"{name}.{signal}": port for signal, port in ports.items()}
    logs = add_logs(builder, signals, period)
    remove_unread_blocks(builder, signals)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(len(rows) * period)
    # A log is a period late; its first row is that of the initial state.
    data = read_logs(logs, simulator.get_context(), {"recording": log.name, "finger": model.name}).data
    return Recording(data.isel(time=slice(1, None)).assign_coords(time=data["time"].values[:-1]))


def zeroed_log(log: FingerLog, layout: MeasurementModel, seconds: float) -> FingerLog:
    """Copy of a log with readings zeroed in its first seconds, in which the finger is free and at rest."""
    rows, sensors = first_rows(log.name, log.time - log.time[0], seconds), strain_sensors(layout, "--zero")
    q = resting_angles(sensors.finger, log.pressure[rows], planar_gravity(log.X_WB[rows], log.gravity))
    differences = log.readings[rows] - sensors.read(q)
    is_unread = ~np.isfinite(differences).any(axis=0)
    require(not is_unread.any(), log.name, "--zero", seconds, f"reading {int(is_unread.argmax())} is NaN until then")
    return replace(log, readings=log.readings - np.nanmean(differences, axis=0))


def first_rows(name: str, time: Array, seconds: float) -> NDArray[np.bool_]:
    """Mask of the samples in the first seconds, of times from 0 on, (T,)."""
    require(seconds < time[-1], name, "--zero", seconds, f"give less than the {time[-1]:g} s that it lasts")
    return time <= seconds
