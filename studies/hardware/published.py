"""The published experiments: what is fitted to which recordings, and which are held out."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.hardware.identification.fit import UNHELD, MotionScore
from soft_gripper.extras.hardware.identification.identified_finger import (
    MEASURED,
    Identified,
    displacement,
    identify,
    read_finger,
)
from soft_gripper.extras.hardware.identification.simulated_motion import (
    MeasuredMotion,
    marker_rotation,
    measured_motion,
    simulated_markers,
)
from soft_gripper.extras.hardware.least_squares import Report
from soft_gripper.extras.hardware.recordings import HardwareRecording, find_recordings
from soft_gripper.extras.hardware.replay.held_out import ALL, ArmReplay, ReplayRow
from soft_gripper.extras.hardware.scoring import FITTED, TESTED
from soft_gripper.extras.paper.claims import Claim
from soft_gripper.files.document import require
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.scenario.model_files import model_path


@dataclass(frozen=True)
class Experiment:
    """A finger fitted to recordings and tested on others; names are those of files without their suffix."""

    description: str  # shipped; also the name of the recordings' folder and of the finger's file
    free: tuple[str, ...]
    fitted: tuple[str, ...]
    tested: tuple[str, ...]

    @property
    def finger_file(self) -> Path:
        """The initial guess of the fit."""
        return model_path(f"package://soft_gripper/recordings/{self.description}.urdf")


BEAM = Experiment(
    "clamped_beam",
    ("youngs_modulus", "relaxation_time", "creep.share", "load_friction", "marker_mass", "held_pose"),
    ("gravity", "load_52g"),
    ("load_101g",),
)
SEGMENT = Experiment(
    "pneumatic_segment",
    (
        "relaxation_time",
        "pressure_law",
        "creep.share",
        "creep.time",
        "fill_time",
        "swelling",
        "length",
        "supply_lag",
        "supply_time",
        "mounting_x",
        "mounting_z",
    ),
    ("10kPa", "25kPa", "45kPa"),
    ("15kPa", "20kPa", "35kPa", "40kPa"),
)
ARM, TRIALS = "two_segment_arm", tuple(f"trial_{i}" for i in range(1, 7))
_LONGEST_TRIAL = "trial_6"  # in which a section is longer than in any other
_SUFFIXES = {BEAM.description: ".csv", SEGMENT.description: ".csv", ARM: ".txt"}

Recordings = dict[str, HardwareRecording]


def published_recordings(data: Path | None) -> dict[str, Recordings]:
    """Reads the recordings by description and name, before anything is computed.

    Args:
        data: the folder with a folder for each description; None: the environment variable SOFT_GRIPPER_DATA.

    Raises:
        InputError: if the folder or one of the files is missing, or cannot be read.
    """
    if data is not None:
        require(data.is_dir(), "hardware", "--data", str(data), "there is no such folder")
    names = {one.description: one.fitted + one.tested for one in (BEAM, SEGMENT)} | {ARM: TRIALS}
    return {description: {name: _find(description, name, data) for name in names[description]} for description in names}


def identify_published(
    experiment: Experiment, recordings: Recordings, executor: Executor, report: Report
) -> Identified:
    """Fits a finger to the fitting recordings of an experiment, and tests it on the others."""
    fitted, tested = (
        [measured_motion(recordings[name]) for name in names] for names in (experiment.fitted, experiment.tested)
    )
    finger = read_finger(experiment.finger_file)
    return identify(finger, experiment.free, fitted, tested, executor, report=report)


def recording_file(description: str, name: str) -> str:
    """The file of a recording, below the folder of all of them."""
    return f"{description}/{name}{_SUFFIXES[description]}"


def _find(description: str, name: str, data: Path | None) -> HardwareRecording:
    return find_recordings([recording_file(description, name)], description, data)[0]


_PUBLISHED_MODULUS = 263.8e3  # Pa, fitted with finite elements by the authors of the beam's recordings
# Logarithmic decrement at 101 g in a repetition that the source recorded too, which is not among the recordings here
_REPEATED_DECREMENT = 0.46


def hardware_claims(beam: Identified, segment: Identified, arm: Sequence[ReplayRow]) -> list[Claim]:
    """Claims on the beam, the segment and the arm."""
    return _beam_claims(beam) + _segment_claims(segment) + _arm_claims(arm)


def _beam_claims(identified: Identified) -> list[Claim]:
    claims = []
    roles = {TESTED: "101 g, held out", UNHELD: "101 g, held out, hold unknown", FITTED: "fitted"}
    for role, text in roles.items():
        settled = _largest(identified, lambda row: row.settled_error_mm, role)
        claims += [
            _bound_claim(f"beam, {text}: settled markers", settled, 1.5, "mm", 2),
            _bound_claim(f"beam, {text}: settled turn", _deviation(identified, "settled_turn_deg", role), 10, "%", 1),
            _bound_claim(f"beam, {text}: frequency", _deviation(identified, "frequency_hz", role), 2, "%", 1),
            _decrement_claim(identified, role, text),
        ]
    finger = identified.model.finger
    relaxed = float(finger.base.youngs_modulus) * (1 - sum(branch.share for branch in finger.creep))
    deviation = 100 * abs(relaxed / _PUBLISHED_MODULUS - 1)
    modulus = _bound_claim("beam: modulus once creep is over", deviation, 10, "%", 1, " of the published")
    return [*claims, replace(modulus, number=f"{modulus.number}, {1e-3 * relaxed:.0f} kPa")]


def _decrement_claim(identified: Identified, role: str, text: str) -> Claim:
    """Claim on a decrement, which if held out deviates only beyond those of the recording and of its repetition."""
    if role == FITTED:
        return _bound_claim(f"beam, {text}: decrement", _deviation(identified, "decrement", role), 15, "%", 1)
    (row,) = (row for row in identified.scores if row.role == role)
    low, high = sorted((row.decrement, _REPEATED_DECREMENT))
    deviation = 100 * abs(row.simulated_decrement / float(np.clip(row.simulated_decrement, low, high)) - 1)
    repetitions = f" of two repetitions, {row.decrement:.2f} and {_REPEATED_DECREMENT}"
    return _bound_claim(f"beam, {text}: decrement", deviation, 15, "%", 1, repetitions)


def _segment_claims(identified: Identified) -> list[Claim]:
    fitted = 100 * identified.fit.error
    rise = float(np.max([_deviation(identified, name) for name in ("t50_ms", "t63_ms")]))
    tip = _largest(identified, lambda row: row.tip_error_percent)
    return [
        Claim("ours", "segment: fit better than 4 %", fitted <= 4, f"{fitted:.2f} %"),
        _bound_claim("segment: settled turn", _deviation(identified, "settled_turn_deg"), 8, "%", 1),
        _bound_claim("segment: times to 50 and 63 % of it", rise, 20, "%", 0),
        _bound_claim("segment: creep", _deviation(identified, "creep_deg"), 35, "%", 0),
        _bound_claim("segment: recovery", _recovery_deviation(identified), 15, "%", 0, " where it was recorded"),
        _bound_claim("segment: tip", tip, 5, "%", 1, " of the length at all times"),
    ]


def _arm_claims(table: Sequence[ReplayRow]) -> list[Claim]:
    rows = {(row.estimator, row.sections, row.recording): row for row in table if row.body == table[-1].body}
    arcs, longest, gaussian = rows["arcs", 2, ALL], rows["arcs", 2, _LONGEST_TRIAL], rows["gaussian", 1, ALL].mean_mm
    ratio = max(rows["gaussian", count, ALL].mean_mm / rows["arcs", count, ALL].mean_mm for count in (1, 2))
    condition, coverage = " (mean) where a section is longer than fitted", longest.within_band_percent
    return [
        _bound_claim("arm: two arcs find the tip", arcs.mean_mm, 3, "mm", 2, " (mean)"),
        _bound_claim("arm: two arcs find the tip", arcs.percentile_95_mm, 6, "mm", 2, " (95th percentile)"),
        _bound_claim("arm: the same", longest.mean_mm, 5, "mm", 2, condition),
        Claim("ours", "arm: there, the band holds 90 % of the samples", coverage >= 90, f"{coverage:.1f} %"),
        _bound_claim("arm: gaussian, one sensor per side,", gaussian, 10, "mm", 2, " (mean)"),
        Claim("ours", "arm: gaussian never worse than arcs (mean)", ratio <= 1, f"{ratio:.2f} times"),
    ]


def _largest(identified: Identified, error: Callable[[MotionScore], float], role: str = TESTED) -> float:
    """Largest error in the recordings of a role; NaN if one is."""
    return float(np.max([error(row) for row in identified.scores if row.role == role]))


def _deviation(identified: Identified, column: str, role: str = TESTED) -> float:
    """The largest difference of a simulated number from the measured one in the recordings of a role, %."""
    return _largest(
        identified, lambda row: 100 * abs(getattr(row, f"simulated_{column}") / getattr(row, column) - 1), role
    )


def _recovery_deviation(identified: Identified) -> float:
    """Deviation of the recovery, in recordings that go on long enough after the valve closes; NaN if none does."""
    rows = [row for row in identified.scores if row.role == TESTED and np.isfinite(row.recovery_deg)]
    return float(np.max([100 * abs(row.simulated_recovery_deg / row.recovery_deg - 1) for row in rows] or [np.nan]))


def _bound_claim(what: str, value: float, bound: float, unit: str, decimals: int, suffix: str = "") -> Claim:
    """A claim that a number is not above a bound."""
    return Claim("ours", f"{what} within {bound:g} {unit}{suffix}", value <= bound, f"{value:.{decimals}f} {unit}")


_COLORS = {FITTED: "#2166ac", TESTED: "#b2182b", UNHELD: "#e08214"}
_LABELS = {FITTED: "simulated, fitted to it", TESTED: "simulated, held out", UNHELD: "held out, hold unknown"}
_DRAWN_TRIAL = "trial_2"  # its sections bend in opposite directions
_ROW_LABELS = {"arcs 2": "arcs, 2 sensors per side", "gaussian 1": "gaussian, 1 sensor per side"}
_TURN_TICKS = (1, 2, 5, 10, 20, 50, 100)  # degrees


def hardware_figure(beam: Identified, segment: Identified, arm: ArmReplay) -> Figure:
    """Three panels: displacement of the beam's tip, turn of the segment's, position of the arm's."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12.5, 3.9), layout="constrained")
        panels = figure.subplots(1, 3)
        _draw_beam(panels[0], beam)
        _draw_segment(panels[1], segment)
        _draw_arm(panels[2], arm)
        for axes in panels:
            axes.margins(x=0)
            axes.title.set_fontsize(10)
        panels[0].legend(frameon=False, fontsize=8, loc="upper right")  # of the segment too
        panels[2].legend(frameon=False, fontsize=8, loc="upper right")

    return figure


def _draw_beam(axes: Axes, identified: Identified) -> None:
    def mass(motion: MeasuredMotion) -> str:
        return "own weight" if motion.load is None else f"{1e3 * motion.load.mass:.0f} g"

    _draw(axes, identified, lambda markers, motion: 1e3 * displacement(markers, motion), mass, 1.45)
    axes.set(xlim=(-0.1, 2.0), ylim=(-2, 58), xlabel="time since release [s]")
    axes.set_ylabel("displacement of the tip [mm]")
    axes.set_title("Silicone beam, released", loc="left")


def _draw_segment(axes: Axes, identified: Identified) -> None:
    def pressure(motion: MeasuredMotion) -> str:
        return f"{1e-3 * (motion.pressure or 0.0):.0f} kPa"

    def turn(markers: Planar, motion: MeasuredMotion) -> Array:
        return np.degrees(marker_rotation(markers, motion.reference))

    _draw(axes, identified, turn, pressure, 1.2)
    axes.set(yscale="log", ylim=(1, 100), xlim=(-0.1, 5.0), xlabel="time since the valve opened [s]")
    axes.set_yticks(_TURN_TICKS, [*map(str, _TURN_TICKS)])
    axes.minorticks_off()
    axes.set_ylabel("turn of the tip [degrees]")
    axes.set_title("Pneumatic segment, pressure steps", loc="left")


def _draw(
    axes: Axes,
    identified: Identified,
    value: Callable[[Planar, MeasuredMotion], Array],
    text: Callable[[MeasuredMotion], str],
    text_time: float,
) -> None:
    """A value of every recording since its event, measured and simulated, with a text at a time, s."""
    for motion, row in zip(identified.motions, identified.scores, strict=True):
        time, labelled = motion.time - motion.events[0], axes.get_legend_handles_labels()[1]
        simulated = value(simulated_markers(identified.model.finger, identified.model.setup, motion), motion)
        measured, color, label = value(motion.markers, motion), _COLORS[row.role], _LABELS[row.role]
        axes.plot(time, measured, **{**MEASURED, "label": "" if labelled else MEASURED["label"]})
        axes.plot(time, simulated, color=color, lw=1.2, label="" if label in labelled else label)
        position = text_time, float(np.interp(text_time, time, measured))
        axes.annotate(text(motion), position, (0, 9), textcoords="offset points", color=color, fontsize=8)


def _draw_arm(axes: Axes, arm: ArmReplay) -> None:
    """The position of the tip across the arm."""
    signals = next(one.signals for one in arm.replayed if one.name == _DRAWN_TRIAL)
    tip = 1e3 * signals["measured_bodies"][1:, -1, 0]
    axes.plot(tip["time"], tip, **MEASURED)
    for (row, label), color in zip(_ROW_LABELS.items(), ESTIMATOR_COLORS[1:], strict=False):
        axes.plot(tip["time"], 1e3 * signals[f"{row}.body_positions"][1:, -1, 0], color=color, lw=1.2, label=label)
    axes.set(xlabel="time [s]", ylabel="tip, across the arm [mm]")
    axes.set_title("Arm of two segments, estimated (trial 2)", loc="left")
