"""Recording: every named signal of a run against time, as labelled arrays with units."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.systems.framework import Context

from soft_gripper.diagrams.sensing import sensor_layout
from soft_gripper.diagrams.signals import (
    CONTACT_FORCE,
    CONTACT_SIGNALS,
    FINGER_SIGNALS,
    GRIP_SIGNALS,
    LABELS,
    PLANT_STATE,
    TASK_SIGNALS,
    WIDTH_SIGNALS,
    Signal,
)
from soft_gripper.diagrams.station import Station
from soft_gripper.files import whole_file


@dataclass(frozen=True)
class Recording:
    """One variable per named signal, such as `left_finger.strain`, over a common `time` (s).

    Each variable has its unit as the attribute `units`. A value at time t is what a reader of the port finds
    at t: a sampled signal still shows the sample before the one that is taken at t.
    """

    data: xr.Dataset

    def __getitem__(self, signal: str) -> xr.DataArray:
        return self.data[signal]

    def save(self, path: Path | str) -> None:
        """Writes one netCDF file, which xarray, MATLAB (ncread) and Julia (NCDatasets) open."""
        with whole_file(Path(path)) as partial:
            self.data.to_netcdf(partial, engine="scipy")

    @staticmethod
    def load(path: Path | str) -> "Recording":
        """Reads a file that `save` wrote."""
        with xr.open_dataset(path, engine="scipy") as data:
            return Recording(data.load())

    def plot(self, *signals: str) -> Figure:
        """Draws signals against time, one below the other, a line for every entry of a vector."""
        figure = Figure(figsize=(8, 2.2 * len(signals)), layout="constrained")
        panels = figure.subplots(len(signals), sharex=True, squeeze=False)[:, 0]
        for axes, signal in zip(panels, signals, strict=True):
            _draw(axes, self.data[signal])
        panels[-1].set_xlabel("time [s]")
        return figure


def _draw(axes: Axes, signal: xr.DataArray) -> None:
    others = [dim for dim in signal.dims if dim != "time"]
    lines = signal.stack(entry=others) if others else signal.expand_dims(entry=[("",)], axis=1)
    for entry, line in zip(lines["entry"].values, lines.transpose("entry", "time"), strict=True):
        axes.plot(signal["time"], line, label=" ".join(map(str, np.atleast_1d(entry).tolist())))
    if 1 < len(lines["entry"]) <= 12:
        axes.legend(title=", ".join(map(str, others)), fontsize="x-small", ncols=3)
    axes.set_title(str(signal.name), loc="left", fontsize="medium")
    axes.set_ylabel(f"[{signal.attrs['units']}]")
    axes.grid(alpha=0.3)


def read_logs(station: Station, context: Context) -> Recording:
    """Collects the logs of a station after a run."""
    variables = {}
    for name in station.logs.signals:
        log = station.logs.find_log(name, context)
        signal, labels = describe(station, name)
        values = log.data().T.reshape(-1, *map(len, labels.values()))
        variables[name] = xr.DataArray(values, labels, ["time", *labels], attrs={"units": signal.unit})
        time = log.sample_times()
    coords = {"time": ("time", time, {"units": "s"})}
    return Recording(xr.Dataset(variables, coords, {"description": station.scenario.description}))


def describe(station: Station, name: str) -> tuple[Signal, dict[str, Any]]:
    """What a signal carries, and the labels along its axes."""
    owner, _, kind = name.partition(".")
    fingers = {finger.name: finger for finger in station.fingers}
    if owner in fingers:
        layout = sensor_layout(station.scenario, fingers[owner])
        signal, joint = (FINGER_SIGNALS | CONTACT_SIGNALS)[kind], f"{owner}.joint"
        paths = ["outer"] if layout.one_sided else ["inner", "outer"]
        own: dict[str, Any] = {
            "path": paths,
            "section": np.arange(layout.sections),
            joint: np.arange(layout.finger.segments),
        }
        axes = [joint if axis == "joint" else axis for axis in signal.axes]
        return signal, {axis: (LABELS | own)[axis] for axis in axes}
    if owner == "grip":
        return (GRIP_SIGNALS | WIDTH_SIGNALS)[kind], {}
    if owner == "task":
        return TASK_SIGNALS[kind], {"arm_state": _arm_state(station)} if TASK_SIGNALS[kind].axes else {}
    if name == "plant.state":
        return PLANT_STATE, {"state": station.plant.GetStateNames()}
    return CONTACT_FORCE, {"wrench": LABELS["wrench"]}


def _arm_state(station: Station) -> list[str]:
    model = station.plant.GetModelInstanceByName(station.scenario.arm.model)
    names: list[str] = station.plant.GetStateNames(model)
    return names
