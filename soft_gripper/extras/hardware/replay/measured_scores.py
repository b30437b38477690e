"""Compares estimates of a finger with instruments: contact force, external torque and rotation, over T samples.

In a press, finger and instrument rest, and the instrument measures more than `MIN_MEASURED`. Medians of all its
samples are compared. Nothing moves then, so neither the delay of an instrument nor the finger's lag counts.
Noise averages out in a median, so the variance of the estimates in a press is subtracted from that of its band.

A force F measured at an arc length s is compared with

- the component of `contact_force_vector` along the instrument's axis, or `contact_force` without one; the band is two
  standard deviations of it;
- `external_torque` at the first joint, compared with the moment of a force F across the finger at s on the
  estimated shape. The band is two standard deviations of the elastic torque and of the driving torque there.
  A common scale of finger and sensors changes neither: a finger that bends further is as much softer.

Bands of a calibrated finger widen away from the states in which it was calibrated (`CalibratedStates`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.estimators.calibration_range import DISAGREEMENT, DISTANCE, FAR
from soft_gripper.estimators.estimate import force_along
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.extras.hardware.finger_logs import FingerLog, nominal_layout, steady
from soft_gripper.extras.hardware.fitted_range import disagreement_warnings, extrapolation_warnings, nearest_distance
from soft_gripper.extras.hardware.instrument import Instrument, InstrumentRun, find_instrument
from soft_gripper.extras.hardware.measured import SI, Measured, latest
from soft_gripper.extras.hardware.replay.finger_estimation import estimate_log, sampled_rows, zeroed_log
from soft_gripper.extras.hardware.replay.held_out import REPORT_PERIOD
from soft_gripper.extras.hardware.scoring import NORMAL_95
from soft_gripper.files.document import require
from soft_gripper.fingers.kinematics import Sites, forward_kinematics
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.sensors.calibrated_states import CalibratedStates, StateDistances

MIN_MEASURED = {"force": 0.05, "torque": 2.5e-3, "angle": 0.02}  # N, N m, rad: smallest values of a press
_REST_TIME = 0.5  # s for which a pressure has been steady, and the instrument, once a finger rests
_STEADY_SHARE = 0.02  # share of the range of either, by which it may vary in that time


@dataclass(frozen=True)
class PressRow:
    """An estimate in a press, compared with an instrument."""

    recording: str
    estimator: str
    quantity: str  # "contact force", "base torque", "torque" or "angle"
    unit: str
    begin_s: Annotated[float, ".1f"]
    end_s: Annotated[float, ".1f"]
    place_mm: Annotated[float, ".0f"]  # along the finger
    measured: Annotated[float, ".3g"]
    estimated: Annotated[float, ".3g"]
    least: Annotated[float, ".3g"]  # ends of the 95 % band of the median; NaN: the estimator states none
    most: Annotated[float, ".3g"]
    within_band_percent: Annotated[float, ".0f"]  # of the samples that have a band; NaN: none has
    far_percent: Annotated[float, ".0f"]  # of the samples far from the states of the calibration; NaN: it has none


@dataclass(frozen=True)
class ScoreRow:
    """An estimate in all presses."""

    estimator: str
    quantity: str
    unit: str
    presses: int
    answered: int  # presses in which the estimate was known
    median_error: Annotated[float, ".3g"]
    percentile_90_error: Annotated[float, ".3g"]
    median_error_percent: Annotated[float, ".1f"]  # of what was measured
    within_band_percent: Annotated[float, ".0f"]
    median_width_percent: Annotated[float, ".0f"]  # of the bands of the medians, of what was measured
    rms_z: Annotated[float, ".2f"]  # root mean square of the errors of the medians over their standard deviations
    ratio: Annotated[float, ".3f"]  # of the measured to the estimated, by least squares over the presses
    ratio_std: Annotated[float, ".3f"]


class _Estimate(NamedTuple):
    """An estimate of an instrument's quantity over time, T samples."""

    quantity: str
    unit: str
    scale: Array  # (T,) estimate per unit of the instrument: 1, or a lever
    estimate: Array  # (T,)
    lower: Array  # (T,)
    upper: Array  # (T,)


@dataclass(frozen=True)
class MeasuredRun:
    """A run of a log with its estimates."""

    log: FingerLog
    signals: Recording
    time: Array  # (T,) s
    measured: dict[str, Measured]  # at these times
    estimates: dict[str, dict[str, list[_Estimate]]]  # by kind of the instrument and estimator
    rest: NDArray[np.bool_]  # (T,) whether the pressure has been steady
    far: Array  # (T,) 1 where it is far from the states of the calibration, NaN without
    warnings: list[str]

    def recording(self) -> Recording:
        """Signals of the estimation, and uncorrected readings of the instruments."""
        variables = {}
        for kind, item in self.measured.items():
            variables[f"measured_{kind}"] = ("time",), item.value, {"units": SI[kind]}
            variables[f"measured_{kind}_place"] = ("time",), item.place, {"units": "m"}
        return Recording(self.signals.data.assign(variables))


@dataclass(frozen=True)
class MeasuredReplay:
    """Logs of a finger, replayed and compared with instruments."""

    runs: Sequence[MeasuredRun]
    instruments: dict[str, Instrument]  # by kind
    presses: list[PressRow]
    scores: list[ScoreRow]
    corrected: dict[str, list[Array]]  # by kind, in each run: (T,) without delay, zero and drift


def replay_measured(
    logs: Sequence[FingerLog], scenario: Scenario, estimators: Sequence[str], zero: float = 0.0
) -> MeasuredReplay:
    """Estimates from the readings of logs of one finger, and compares with instruments.

    For `zero` s, the finger is free and at rest at the beginning of every log, see `zeroed_log`; 0: not.
    """
    logs = [log for log in logs if log.measured]
    expected = "is described in no log: give measured_force, measured_torque or measured_angle of the finger"
    require(len(logs) > 0, "replay", "measured_force", None, expected)
    fingers = sorted({log.finger.name for log in logs})
    require(len(fingers) == 1, "replay", "measured_force", fingers, "describe the instruments of one finger at a time")
    names = [log.name for log in logs]
    expected = "each needs a name of its own, after which results are called"
    require(len({*names}) == len(names), "replay", "FILE", names, expected)
    kinds = [*logs[0].measured]
    progress = tqdm(logs, desc="replay", mininterval=REPORT_PERIOD, dynamic_ncols=True)
    runs = [_replay_log(log, scenario, estimators, zero) for log in progress]
    instruments, corrected_values = dict[str, Instrument](), dict[str, list[Array]]()
    for kind in kinds:
        instrument_runs = [_instrument_run(run, kind) for run in runs]
        instruments[kind] = Instrument(0.0, (0.0,) * len(runs), 0.0)  # an angle has no zero: a finger always has one
        if kind != "angle":
            instruments[kind] = find_instrument(instrument_runs, MIN_MEASURED[kind])
        corrected_values[kind] = [instruments[kind].corrected(i, run) for i, run in enumerate(instrument_runs)]
    presses = [
        row
        for i, run in enumerate(runs)
        for kind in kinds
        for rows in _find_presses(run, corrected_values[kind][i], MIN_MEASURED[kind])
        for row in _press_rows(run, kind, corrected_values[kind][i], rows)
    ]
    kind = kinds[0]
    expected = f"nowhere rests for {_REST_TIME:g} s while more than {MIN_MEASURED[kind]:g} {SI[kind]} is measured"
    require(len(presses) > 0, "replay", f"measured_{kind}", names, expected)
    return MeasuredReplay(runs, instruments, presses, _press_scores(presses), corrected_values)


def _replay_log(log: FingerLog, scenario: Scenario, estimators: Sequence[str], zero: float) -> MeasuredRun:
    layout, period = nominal_layout(scenario, log.finger), scenario.sensor.period
    if zero > 0:
        log = zeroed_log(log, layout, zero)
    signals = estimate_log(log, scenario, estimators)
    rows = sampled_rows(log, period)
    assumed = uncertainty(scenario.estimator, scenario.sensor, layout.calibrated)
    time, mechanics = period * np.arange(len(rows)), Mechanics(layout, assumed)
    measured = {
        kind: Measured(latest(log.time, item.value)[rows], latest(log.time, item.place)[rows], item.along)
        for kind, item in log.measured.items()
    }
    estimates = {
        kind: {name: [*_find_estimates(signals, name, kind, item, mechanics)] for name in estimators}
        for kind, item in measured.items()
    }
    pressure, far, warnings = log.pressure[rows], np.full(len(rows), np.nan), list[str]()
    is_at_rest = steady(pressure, round(_REST_TIME / period), _STEADY_SHARE * float(np.ptp(pressure))) & (time >= zero)
    if layout.calibrated is not None:
        far = signals[f"{estimators[0]}.{FAR}"].values.ravel()
        warnings = _warnings(signals, estimators[0], layout.calibrated)
    return MeasuredRun(log, signals, time, measured, estimates, is_at_rest, far, warnings)


def _warnings(signals: Recording, name: str, states: CalibratedStates) -> list[str]:
    """Warnings that a run leaves the states of the calibration, or disagrees with them."""
    time, pressure = signals["time"].values, signals["sampled_pressure"].values.ravel()
    distance, disagreement = signals[f"{name}.{DISTANCE}"].values, signals[f"{name}.{DISAGREEMENT}"].values.ravel()

    def describe_state(row: int, part: int) -> str:
        pressure_text = f"under {1e-3 * pressure[row]:.0f} kPa"
        return f"its drive {pressure_text}" if part == 0 else f"the readings of section {part - 1} {pressure_text}"

    far = signals[f"{name}.{FAR}"].values.ravel() == 1
    warnings = extrapolation_warnings(time, distance, far, describe_state)
    return warnings + disagreement_warnings(
        "readings and pressure", nearest_distance(disagreement), states.disagreement
    )


def _find_estimates(
    signals: Recording, name: str, kind: str, measured: Measured, mechanics: Mechanics
) -> Iterator[_Estimate]:
    """Yields the estimates of an instrument's quantity by an estimator."""
    finger = mechanics.layout.finger
    q = signals[f"{name}.{ANGLES}"].values
    chain = forward_kinematics(q, finger.segment_length)
    place = np.nan_to_num(measured.place)[:, None]
    torque = signals[f"{name}.external_torque"].values
    if kind == "angle":
        turn = np.take_along_axis(chain.headings, chain.link_at(place), axis=-1)[:, 0]
        std = np.full(len(q), np.nan)
        if f"{name}.joint_angle_covariance" in signals.data:
            is_before = (np.arange(q.shape[-1]) < chain.link_at(place)).astype(float)
            covariance = signals[f"{name}.joint_angle_covariance"].values
            std = np.sqrt(np.einsum("ti,tij,tj->t", is_before, covariance, is_before))
        yield _Estimate("angle", "rad", np.ones(len(q)), turn, turn - NORMAL_95 * std, turn + NORMAL_95 * std)
        return
    if kind == "force":
        label, scale, joint_torque = "base torque", _lever(chain.sites(place), measured), torque[:, 0]
        joint = np.zeros(len(q), dtype=int)
    else:
        label, scale = "torque", np.ones(len(q))
        joint_torque = _interpolate_torque(torque, place[:, 0] / finger.segment_length)
        joint = np.minimum(chain.link_at(place)[:, 0], q.shape[-1] - 1)
    half_width = NORMAL_95 * _torque_std(signals, name, joint, mechanics)
    yield _Estimate(label, "N m", scale, joint_torque, joint_torque - half_width, joint_torque + half_width)
    if kind == "force" and f"{name}.contact_force_vector_covariance" in signals.data:
        yield _contact_estimate(signals, name, measured, len(q))


def _interpolate_torque(torque: Array, segments: Array) -> Array:
    """Interpolates the torque of the joints, (T, N), at positions, (T,) in segments from the base."""
    joint = np.clip(np.floor(segments - 0.5).astype(int), 0, torque.shape[-1] - 2)
    fraction = np.minimum(segments - 0.5 - joint, 1.0)  # below 0 between the base and the first joint
    lower_torque, upper_torque = (np.take_along_axis(torque, (joint + i)[:, None], axis=-1)[:, 0] for i in (0, 1))
    return lower_torque + fraction * (upper_torque - lower_torque)


def _lever(site: Sites, measured: Measured) -> Array:
    """Moment at the first joint, per N along the instrument's axis, of a normal force, (T,) m."""
    axis_fraction = np.ones(len(site.points))
    if measured.along is not None:
        axis = complex(measured.along[1], measured.along[0]) / np.hypot(*measured.along)
        axis_fraction = (-site.normals * np.conj(axis)).real[:, 0]
    lever = site.torques(-site.normals)[:, 0, 0]
    return np.asarray(lever / np.where(np.abs(axis_fraction) > _MIN_AXIS_SHARE, axis_fraction, np.nan))


_MIN_AXIS_SHARE = 0.2  # share of a force across the finger along an instrument's axis; with less, the lever is unknown


def _torque_std(signals: Recording, name: str, joint: NDArray[np.int_], mechanics: Mechanics) -> Array:
    """Standard deviation of the external torque at joints (T,), N m; NaN if the estimator has none of the shape."""
    if f"{name}.joint_angle_covariance" not in signals.data:
        return np.full(len(joint), np.nan)
    finger, states = mechanics.layout.finger, mechanics.layout.calibrated
    covariance = signals[f"{name}.joint_angle_covariance"].values
    if states is not None:
        covariance = covariance - mechanics.scale_covariance(signals[f"{name}.{ANGLES}"].values)
    elastic = finger.stiffness**2 * np.diagonal(covariance, axis1=-2, axis2=-1)
    torque = finger.pressure_torque(signals["sampled_pressure"].values.reshape(len(joint)))
    driving = ((mechanics.bend_changes[:, : finger.segments] * torque[:, None]) ** 2).sum(axis=1)
    if states is not None:
        drive, sections = np.split(signals[f"{name}.{DISTANCE}"].values, [1], axis=-1)
        extrapolation = mechanics.extrapolation_at(states, StateDistances(drive[:, 0], sections, drive[:, 0]))
        driving = driving + (extrapolation.pressure[:, None] * finger.pressure_gain) ** 2
    return np.sqrt(np.take_along_axis(elastic + driving, joint[:, None], axis=-1)[:, 0])


def _contact_estimate(signals: Recording, name: str, measured: Measured, samples: int) -> _Estimate:
    """The contact force along the axis of an instrument, or across the finger without one."""
    if measured.along is None:
        estimate, std = (signals[f"{name}.{signal}"].values for signal in ("contact_force", "contact_force_std"))
    else:
        x, z = np.array(measured.along) / np.hypot(*measured.along)
        vector, covariance = (
            signals[f"{name}.{signal}"].values for signal in ("contact_force_vector", "contact_force_vector_covariance")
        )
        estimate, std = force_along(vector, covariance.reshape(samples, 3, 3), np.array([x, 0.0, z]))
    estimate, half_width = estimate.reshape(samples), NORMAL_95 * std.reshape(samples)
    return _Estimate("contact force", "N", np.ones(samples), estimate, estimate - half_width, estimate + half_width)


def _instrument_run(run: MeasuredRun, kind: str) -> InstrumentRun:
    """Measurements of an instrument, beside the first estimate of it."""
    first_estimate = next(iter(run.estimates[kind].values()))[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        estimate = first_estimate.estimate / np.where(np.abs(first_estimate.scale) > 1e-6, first_estimate.scale, np.nan)
    return InstrumentRun(run.time, run.measured[kind].value, estimate, run.rest)


def _find_presses(run: MeasuredRun, value: Array, minimum: float) -> Iterator[NDArray[np.int_]]:
    """Yields the indices of the samples of each press, by the corrected value of an instrument, (T,)."""
    steps = np.abs(np.diff(value))
    resolution = float(np.min(steps[steps > 1e-9], initial=np.inf))
    value_range = float(np.nanmax(value) - np.nanmin(value))
    max_range = max(_STEADY_SHARE * value_range, 2 * resolution if np.isfinite(resolution) else 0.0)
    period = float(run.time[1] - run.time[0])
    rows = np.flatnonzero(run.rest & steady(value, round(_REST_TIME / period), max_range) & (np.abs(value) > minimum))
    for press_rows in np.split(rows, np.flatnonzero(np.diff(rows) * period > _REST_TIME) + 1):
        if len(press_rows) * period >= _REST_TIME:
            yield press_rows


def _press_rows(run: MeasuredRun, kind: str, value: Array, rows: NDArray[np.int_]) -> Iterator[PressRow]:
    """Yields a row of a press for each estimate."""
    ends = float(run.log.time[0] + run.time[rows[0]]), float(run.log.time[0] + run.time[rows[-1]])
    place = 1e3 * float(np.median(run.measured[kind].place[rows]))
    for name, estimates in run.estimates[kind].items():
        for estimate in estimates:
            measured, samples = value[rows] * estimate.scale[rows], estimate.estimate[rows]
            lower, upper = estimate.lower[rows], estimate.upper[rows]
            has_band, is_inside = np.isfinite(lower), (lower <= measured) & (measured <= upper)
            percentage = 100 * float(is_inside[has_band].mean()) if has_band.any() else np.nan
            estimated = _known_median(samples, np.isfinite(samples))
            medians = _known_median(lower, has_band), _known_median(upper, has_band)
            band = _lasting_band(estimated, *medians, samples[np.isfinite(samples)])
            labels = run.log.name, name, estimate.quantity, estimate.unit
            far = 100 * float(run.far[rows].mean())
            yield PressRow(*labels, *ends, place, float(np.median(measured)), estimated, *band, percentage, far)


def _known_median(values: Array, is_known: NDArray[np.bool_]) -> float:
    """Median of the known values; NaN if at most half are known."""
    return float(np.median(values[is_known])) if is_known.sum() * 2 > len(values) else np.nan


def _lasting_band(estimate: float, lower: float, upper: float, samples: Array) -> tuple[float, float]:
    """Ends of the band of a median, without the variance of the independent samples."""
    variance = ((upper - lower) / (2 * NORMAL_95)) ** 2
    sample_variance = float(np.var(samples)) if len(samples) else np.nan
    half_width = NORMAL_95 * np.sqrt(max(variance - sample_variance, sample_variance / max(len(samples), 1)))
    return estimate - half_width, estimate + half_width


def _press_scores(presses: Sequence[PressRow]) -> list[ScoreRow]:
    """Scores of each estimate over all presses."""
    scores = []
    for key in dict.fromkeys((row.estimator, row.quantity, row.unit) for row in presses):
        rows = [row for row in presses if (row.estimator, row.quantity, row.unit) == key]
        measured, estimated = (np.array([getattr(row, name) for row in rows]) for name in ("measured", "estimated"))
        is_known = np.isfinite(measured + estimated)
        error = np.abs(estimated - measured)[is_known]
        percentages = np.array([row.within_band_percent for row in rows])
        width = np.array([row.most - row.least for row in rows])[is_known]
        z = 2 * NORMAL_95 * error / width
        numbers = {
            "presses": len(rows),
            "answered": int(is_known.sum()),
            "median_error": _quantile(error, 0.5),
            "percentile_90_error": _quantile(error, 0.9),
            "median_error_percent": 100 * _quantile(error / np.abs(measured[is_known]), 0.5),
            "within_band_percent": float(np.nanmean(percentages)) if np.isfinite(percentages).any() else np.nan,
            "median_width_percent": 100 * _quantile(width / np.abs(measured[is_known]), 0.5),
            "rms_z": float(np.sqrt((z**2).mean())) if len(z) else np.nan,
        }
        ratio, std = _fit_ratio(measured[is_known], estimated[is_known])
        scores.append(ScoreRow(*key, **numbers, ratio=ratio, ratio_std=std))  # type: ignore[arg-type]
    return scores


def _quantile(errors: Array, share: float) -> float:
    return float(np.quantile(errors, share)) if len(errors) else np.nan


def _fit_ratio(measured: Array, estimated: Array) -> tuple[float, float]:
    """Least-squares ratio of measured to estimated values, (N,) each, and its standard deviation."""
    size = float(estimated @ estimated)
    if len(measured) < 2 or size == 0:
        return np.nan, np.nan
    ratio = float(measured @ estimated) / size
    residuals = measured - ratio * estimated
    return ratio, float(np.sqrt(residuals @ residuals / (len(residuals) - 1) / size))


_MAX_DRAWN_RUNS = 4  # drawn over time
_MEASURED_COLOR = "0.1"
_CUT_PERCENT = 1.0  # percent of the samples beyond either end of the axis


def measured_figure(replay: MeasuredReplay) -> Figure:
    """Plots the first instrument and its estimates over time, with their bands, a panel for each run."""
    kind = next(iter(replay.instruments))
    names = list(replay.runs[0].estimates[kind])
    colors = dict(zip(names, ESTIMATOR_COLORS[1:], strict=False))
    runs = range(min(len(replay.runs), _MAX_DRAWN_RUNS))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(1.2 + 2.6 * len(runs), 3.2), layout="constrained")
        panels = figure.subplots(1, len(runs), squeeze=False, sharey=True)[0]
        for number in runs:
            _draw_run(panels[number], replay, kind, number, colors)
        panels[0].set_ylabel(f"{kind} [{SI[kind]}]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _draw_run(axes: Axes, replay: MeasuredReplay, kind: str, number: int, colors: dict[str, str]) -> None:
    run = replay.runs[number]
    for name, color in colors.items():
        estimate = run.estimates[kind][name][-1]  # the contact force, if it is estimated
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high, middle = (
                curve / estimate.scale for curve in (estimate.lower, estimate.upper, estimate.estimate)
            )
        axes.fill_between(run.time, low, high, color=color, alpha=0.2, lw=0)
        axes.plot(run.time, middle, color=color, lw=1.0, label=f"{name}: {estimate.quantity}")
    axes.plot(run.time, replay.corrected[kind][number], color=_MEASURED_COLOR, lw=1.2, ls=(0, (4, 2)), label="measured")
    values = np.concatenate(replay.corrected[kind])
    low_end, high_end = np.nanpercentile(values, [_CUT_PERCENT, 100 - _CUT_PERCENT])
    axes.set(ylim=(low_end - 0.3 * (high_end - low_end), high_end + 0.5 * (high_end - low_end)), xlabel="time [s]")
    axes.set_title(run.log.name, fontsize=9, loc="left")
