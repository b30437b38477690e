"""Estimators on recordings of one arm: each is estimated with a model fitted to the others, or to chosen ones."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS, find_estimator
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.recordings import HardwareRecording
from soft_gripper.extras.hardware.replay.arm_estimation import (
    PERIOD,
    ArmRecording,
    NominalArm,
    ReplayInputs,
    arm_recording,
    estimate_recording,
)
from soft_gripper.extras.hardware.replay.geometry_band import (
    GeometryBand,
    body_band,
    disagreements,
    extrapolations,
    learn_band,
)
from soft_gripper.extras.hardware.replay.geometry_fit import (
    ArmGeometry,
    fit_drive,
    fit_geometry,
    measured_poses,
    zero_geometry,
)
from soft_gripper.extras.hardware.replay.view import arm_corners
from soft_gripper.extras.hardware.scoring import (
    Split,
    ball_rms_z,
    error_columns,
    leave_one_out,
    percent_within,
    predictions,
)
from soft_gripper.files.document import require_value
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.scenario.model_files import model_path

REPORT_PERIOD = 1.0  # s, between two reports of the progress at least
Rows = Mapping[str, tuple[str, int]]  # name of an estimator and its sensors per side, by the name of the row
_LOAD_SHARE = 0.1  # torque of a load over that of the angles that a drive leaves unexplained


@dataclass(frozen=True)
class FittedArm:
    """A fitted arm, its geometry, and the band of its bodies."""

    arm: NominalArm
    geometry: ArmGeometry
    band: GeometryBand


@dataclass(frozen=True)
class Replayed:
    """A recording with its estimates."""

    name: str
    fitted_on: tuple[str, ...]
    fitted: FittedArm
    signals: Recording
    warnings: tuple[str, ...]  # where it is far from what was fitted, and disagrees with it
    first: int  # sample that is scored: those before are not estimated, or zeroed


def estimator_rows(names: Iterable[str] | None, sections: int) -> Rows:
    """Estimators, None for all, with one sensor per side over the whole arm, and with one for each section."""
    estimator_names = list(names or SHAPE_FUNCTIONS)
    for name in estimator_names:
        find_estimator(name, field="--estimator")
    return {f"{name} {sensors}": (name, sensors) for sensors in sorted({1, sections}) for name in estimator_names}


@dataclass(frozen=True)
class ReplayRow:
    """Errors of one estimator over a recording, or over the samples of all recordings."""

    estimator: str
    sections: int  # sensors per side
    recording: str
    body: str
    mean_mm: float
    median_mm: float
    percentile_95_mm: float
    max_mm: float
    # Of arcs with a sensor for each section, NaN otherwise
    within_band_percent: float  # samples within the 95 % band
    rms_z: float  # errors along an axis over their standard deviations, root mean square: 1 is right
    band_mm: float  # mean radius
    far_percent: float  # samples that are far from what was fitted


@dataclass(frozen=True)
class ArmReplay:
    """Recordings of one arm with their estimates, and the errors of these."""

    replayed: list[Replayed]
    rows: Rows

    @cached_property
    def table(self) -> list[ReplayRow]:
        """Errors of each estimator, see `replay_table`."""
        return replay_table(self.replayed, self.rows)


def replay(
    reported: Sequence[HardwareRecording],
    fitted: Sequence[HardwareRecording] | None = None,
    estimators: Iterable[str] | None = None,
    zero: float = 0.0,
) -> ArmReplay:
    """Estimates recordings of one arm, whose description names the finger that represents it.

    Args:
        reported: recordings to estimate.
        fitted: recordings for the fit; None: for each recording, all others.
        estimators: names; None: all built-in ones.
        zero: s, for which the pose of every reported recording is known at first, see `zero_geometry`; 0: not.

    Raises:
        InputError: if the description names no file with one finger, or no gravity, or recordings do not fit it.
    """
    name, config = reported[0].name, reported[0].config
    file = require_value(config.finger, name, "finger", "name the URDF with the finger that models the arm")
    finger = read_finger(model_path(file))
    expected = "give the direction of gravity: the arm bends under its own weight"
    gravity = require_value(reported[0].gravity, name, "gravity", expected)
    arms = [arm_recording(recording) for recording in reported]
    rows = estimator_rows(estimators, len(arms[0].bodies))
    to_fit = None if fitted is None else [arm_recording(recording) for recording in fitted]
    return replay_recordings(arms, to_fit, rows, finger, gravity, zero)


def replay_recordings(
    reported: Sequence[ArmRecording],
    fitted: Sequence[ArmRecording] | None,
    rows: Rows,
    finger: Finger,
    gravity: Array,
    zero: float = 0.0,
) -> ArmReplay:
    """Estimates recordings as `replay` does, by a finger that represents the arm, with gravity in B.

    A recording is never part of the data that its own estimates were fitted to.
    """
    names = [recording.name for recording in reported]
    if twice := sorted({*names} & {recording.name for recording in fitted or ()}):
        raise InputError("replay", "--fit", twice, "a recording cannot be both fitted and reported")
    if fitted is None and len(reported) < 2:
        expected = "each is estimated by a fit to the others: give at least two, or --fit"
        raise InputError("replay", "FILE", names, expected)
    splits = leave_one_out(reported) if fitted is None else [Split(fitted, reported)]

    def fit(others: Sequence[ArmRecording]) -> Callable[[ArmRecording], Replayed]:
        fitted_arm = fit_arm(others, finger, gravity)
        fitted_on = tuple(other.name for other in others)
        return lambda recording: _replayed(recording, fitted_arm, fitted_on, rows, finger, zero)

    replays = predictions(splits, fit)  # with a report of the progress, in a log as well
    reports = tqdm(replays, desc="replay", total=len(reported), mininterval=REPORT_PERIOD, dynamic_ncols=True)
    return ArmReplay(list(reports), rows)


def _replayed(
    recording: ArmRecording, fitted: FittedArm, fitted_on: tuple[str, ...], rows: Rows, finger: Finger, zero: float
) -> Replayed:
    geometry, variants, first = fitted.geometry, tuple[ArmGeometry, ...](), 1
    if zero > 0:
        zeroed = zero_geometry(geometry, recording, finger, zero, fitted.band.std)
        geometry, variants = zeroed.geometry, zeroed.variants
        first += int(np.searchsorted(recording.time, zero, side="right"))
    names = {"recording": recording.name, "fitted_on": ", ".join(fitted_on), "zeroed_s": f"{zero:g}"}
    about = names | {"wires_late_by_s": f"{fitted.geometry.delay:g}"}
    fitted = replace(fitted, arm=replace(fitted.arm, wires=geometry.wires), geometry=geometry)
    signals = estimate_recording(fitted.arm, replay_inputs(recording, geometry.delay), rows, about)
    band = body_band(fitted.band, geometry, recording, finger, variants)
    bands = {
        BAND: (("time", "body"), band.radius, {"units": "m"}),
        DISTANCE: (("time", "arm_section"), band.distance, {"units": "1"}),
        FAR: (("time",), band.is_far),
    }
    warnings = extrapolations(geometry, recording, band) + disagreements(fitted.band, geometry, recording)
    return Replayed(recording.name, fitted_on, fitted, Recording(signals.data.assign(bands)), tuple(warnings), first)


def fit_arm(recordings: Sequence[ArmRecording], finger: Finger, gravity: Array) -> FittedArm:
    """The nominal model of an arm, fitted to recordings of it."""
    geometry_fit = fit_geometry(recordings, finger)
    geometry = geometry_fit.model
    drive = fit_drive(recordings, geometry, finger, gravity)
    driven_chamber = np.argmax(finger.pressure_gain)
    load = _LOAD_SHARE * drive.angle_std * finger.stiffness[driven_chamber] / finger.pressure_gain[driven_chamber]
    noise = _noise(recordings)
    uncertainty = Uncertainty(reading=noise, angle=drive.angle_std, bend_per_pressure=EXACT, load_pressure=float(load))
    arm = NominalArm(drive.finger, drive.gains, drive.rest, geometry.wires, geometry.parts, uncertainty, gravity)
    return FittedArm(arm, geometry, learn_band(geometry_fit, recordings, finger))


def replay_inputs(recording: ArmRecording, delay: float) -> ReplayInputs:
    """The inputs of the diagram from a recording; body positions are those a `delay` (s) earlier."""
    bodies, _ = measured_poses(recording, delay)
    wires = np.stack([recording.inner, recording.outer], axis=1)
    return ReplayInputs(PERIOD, wires, recording.pressures, recording.bodies, as_points(bodies))


def _noise(recordings: Sequence[ArmRecording]) -> float:
    """Standard deviation of the wires' extension ratios, from the steps between successive different samples.

    Robust against motion, which makes steps of another size.
    """
    wires = [np.diff(np.concatenate([r.inner, r.outer], axis=1) / r.inner[:, -1].mean(), axis=0) for r in recordings]
    steps = np.concatenate([step.ravel() for step in wires])
    return float(1.48 * np.median(np.abs(steps[steps != 0])) / np.sqrt(2))


ALL = "all"
# Signals: radius of the 95 % band of every body about its place by arcs; distance of every section from the fitted
# states, in their spreads; whether it makes more of the band than all else does
BAND, DISTANCE, FAR = "body_band", "state_distance", "is_far"
_BAND_COLUMNS = "within_band_percent", "rms_z", "band_mm", "far_percent"


def replay_table(replayed: Sequence[Replayed], rows: Rows) -> list[ReplayRow]:
    """A row for each estimator, body and recording, and for all recordings together.

    The first sample, which is logged before the sensors are read, is omitted, and so are those that zero the wires.
    """
    table = []
    far = _add_total({run.name: run.signals[FAR].values[run.first :] for run in replayed})
    for row, (estimator, sections) in rows.items():
        errors = {run.name: 1e3 * run.signals[f"{row}.body_error"][run.first :] for run in replayed}
        bodies = next(iter(errors.values()))["body"].values
        for i, body in enumerate(bodies):
            bands = _add_total({run.name: 1e3 * run.signals[BAND].values[run.first :, i] for run in replayed})
            for name, values in _add_total({name: error.values[:, i] for name, error in errors.items()}).items():
                numbers = error_columns(values, "mean_mm", "median_mm", "percentile_95_mm", "max_mm")
                percentages = percent_within(values, bands[name]), ball_rms_z(values, bands[name], 2)
                band_numbers = *percentages, float(bands[name].mean()), 100 * float(far[name].mean())
                if estimator != "arcs" or sections != len(bodies):
                    band_numbers = (np.nan,) * 4
                columns = dict(zip(_BAND_COLUMNS, band_numbers, strict=True))
                table.append(ReplayRow(estimator, sections, name, str(body), **numbers, **columns))
    return table


def _add_total(values: dict[str, Array]) -> dict[str, Array]:
    """Values by recording, and concatenated for all recordings."""
    return {**values, ALL: np.concatenate([*values.values()])}


_PREFERRED_ESTIMATORS = ("arcs", "gaussian")
_MEASURED_COLOR = "0.1"
_SMOOTHED_SAMPLES = 50  # samples, over which errors are averaged
_MAX_DRAWN = 4  # estimators in a figure, so that each can be seen


def drawn_rows(rows: Rows) -> dict[str, str]:
    """The rows to draw, with their colours."""
    drawn = [row for row, (name, _) in rows.items() if name in _PREFERRED_ESTIMATORS] or list(rows)
    return dict(zip(drawn[:_MAX_DRAWN], ESTIMATOR_COLORS[1:], strict=False))


def replay_figure(replay: ArmReplay) -> Figure:
    """Plots tip position across the arm, tip error and shape, with a column for each recording."""
    colors, replayed = drawn_rows(replay.rows), replay.replayed
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(1.2 + 2.5 * len(replayed), 8.2), layout="constrained")
        heights = {"height_ratios": [1, 0.8, 1.9]}
        panels = figure.subplots(3, len(replayed), sharex="row", sharey="row", squeeze=False, gridspec_kw=heights)
        for column, run in zip(panels.T, replayed, strict=True):
            column[0].set_title(run.name.replace("_", " "), fontsize=10, loc="left")
            _draw_tip(column[0], run, colors)
            _draw_errors(column[1], run, colors)
            _draw_shape(column[2], run, colors)
        panels[0, 0].set_ylabel("tip, across the arm [mm]")
        panels[1, 0].set_ylabel("error of the tip,\n1 s means [mm]")
        panels[2, 0].set_ylabel("down [mm]")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _draw_tip(axes: Axes, run: Replayed, colors: dict[str, str]) -> None:
    tip = 1e3 * run.signals["measured_bodies"][1:, -1, 0]
    for row, color in colors.items():
        estimated = 1e3 * run.signals[f"{row}.body_positions"][1:, -1, 0]
        axes.plot(tip["time"], estimated, color=color, lw=1.0, label=f"{row} per side".replace(" ", ", ", 1))
    axes.plot(tip["time"], tip, color=_MEASURED_COLOR, lw=1.4, ls=(0, (4, 2)), label="motion capture")


def _draw_errors(axes: Axes, run: Replayed, colors: dict[str, str]) -> None:
    for row, color in colors.items():
        error = 1e3 * run.signals[f"{row}.body_error"][1:, -1]
        axes.plot(
            error["time"], error.rolling(time=_SMOOTHED_SAMPLES, center=True, min_periods=1).mean(), color=color, lw=1.2
        )
    axes.set(yscale="log", ylim=(1, 100), xlabel="time [s]")
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    axes.minorticks_off()


def _draw_shape(axes: Axes, run: Replayed, colors: dict[str, str]) -> None:
    """Draws the shape at the sample with the largest spread of the bodies across the arm."""
    bodies = run.signals["measured_bodies"].values[1:]
    place = 1 + int(np.argmax(np.abs(np.diff(bodies[:, :, 0], axis=1, prepend=0.0)).sum(axis=1)))
    for row, color in colors.items():
        x, _, z = 1e3 * arm_corners(run.signals, row, place).T
        axes.plot(x, z, color=color, lw=1.6, marker="o", ms=2)
    axes.plot(*(1e3 * bodies[place - 1].T), color=_MEASURED_COLOR, ls="", marker="s", mfc="none", ms=8, mew=1.5)
    time = float(run.signals.data["time"][place])
    axes.set_title(f"at {time:.1f} s; squares: motion capture", fontsize=8, loc="left")
    axes.set(aspect="equal", xlabel="across [mm]")
    axes.margins(0.15)
    if not axes.yaxis_inverted():
        axes.invert_yaxis()
