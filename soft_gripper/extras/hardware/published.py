"""The published experiments: what is fitted to which recordings, and which are held out."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.evaluation.paper.claims import Claim
from soft_gripper.extras.hardware.identification.fit import FITTED, TESTED, UNHELD, MotionScore
from soft_gripper.extras.hardware.identification.identified_finger import (
    MEASURED,
    Identified,
    displacement,
    identify,
    read_finger,
)
from soft_gripper.extras.hardware.identification.simulated_motion import (
    MeasuredMotion,
    measured_motion,
    simulated_markers,
    turned,
)
from soft_gripper.extras.hardware.recordings import HardwareRecording, find_recordings
from soft_gripper.extras.hardware.replay.arm_estimation import arm_recording
from soft_gripper.extras.hardware.replay.held_out import (
    ALL,
    ArmReplay,
    ReplayRow,
    estimator_rows,
    replay_recordings,
)
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
    ("youngs_modulus", "relaxation_time", "creep.share", "marker_mass", "held_pose"),
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
        "supply_lag",
        "supply_time",
        "mounting_x",
        "mounting_z",
    ),
    ("10kPa", "25kPa", "45kPa"),
    ("15kPa", "35kPa"),
)
ARM, TRIALS = "two_segment_arm", tuple(f"trial_{i}" for i in range(1, 7))
_LONGEST = "trial_6"  # in which a section is longer than in any other
_SUFFIXES = {BEAM.description: ".csv", SEGMENT.description: ".csv", ARM: ".txt"}

Recordings = dict[str, HardwareRecording]
Report = Callable[[str, float], None]  # which experiment, and the root mean square error of its fit


def published_recordings(data: Path | None) -> dict[str, Recordings]:
    """All recordings by description and name, read before anything is computed.

    Args:
        data: the folder with a folder for each description; None: the environment variable SOFT_GRIPPER_DATA.

    Raises:
        InputError: if the folder or one of the files is missing, or cannot be read.
    """
    if data is not None:
        require(data.is_dir(), "hardware", "--data", str(data), "there is no such folder")
    wanted = {of.description: of.fitted + of.tested for of in (BEAM, SEGMENT)} | {ARM: TRIALS}
    return {
        description: {name: _find(description, name, data) for name in names} for description, names in wanted.items()
    }


def identify_published(
    experiment: Experiment, recordings: Recordings, executor: Executor, report: Report
) -> Identified:
    """Fits a finger to the fitting recordings of an experiment, and tests it on the others."""
    fitted, tested = (
        [measured_motion(recordings[name]) for name in names] for names in (experiment.fitted, experiment.tested)
    )
    finger = read_finger(experiment.finger_file)
    return identify(
        finger,
        experiment.free,
        fitted,
        tested,
        executor,
        report=lambda error: report(experiment.description, error),
    )


def replay_published(recordings: Sequence[HardwareRecording]) -> ArmReplay:
    """Every trial of the arm with every estimator, fitted to the other trials."""
    arms, config, gravity = [arm_recording(one) for one in recordings], recordings[0].config, recordings[0].gravity
    assert config.finger is not None
    assert gravity is not None
    rows = estimator_rows(None, len(arms[0].bodies))
    return replay_recordings(arms, None, rows, read_finger(model_path(config.finger)), gravity)


def _find(description: str, name: str, data: Path | None) -> HardwareRecording:
    file = f"{description}/{name}{_SUFFIXES[description]}"
    return find_recordings([file], description, data)[0]


_PUBLISHED_MODULUS = 263.8e3  # Pa, fitted with finite elements by the authors of the beam's recordings


def hardware_claims(beam: Identified, segment: Identified, arm: Sequence[ReplayRow]) -> list[Claim]:
    """All of them."""
    return _of_beam(beam) + _of_segment(segment) + _of_arm(arm)


def _of_beam(found: Identified) -> list[Claim]:
    relaxed = _relaxed_modulus(found)
    modulus = _off(relaxed, _PUBLISHED_MODULUS)
    claims = []
    roles = {TESTED: "101 g, held out", UNHELD: "101 g, held out, hold unknown", FITTED: "fitted"}
    for role, text in roles.items():
        turn = _worst(found, _off_turn, role)
        settled = _worst(found, lambda row: row.settled_error_mm, role)
        frequency = _worst(found, lambda row: _off(row.simulated_frequency_hz, row.frequency_hz), role)
        decrement = _worst(found, lambda row: _off(row.simulated_decrement, row.decrement), role)
        claims += [
            _claim(f"beam, {text}: settled markers within 1.5 mm", settled <= 1.5, f"{settled:.2f} mm"),
            _claim(f"beam, {text}: settled turn within 10 %", turn <= 0.1, f"{100 * turn:.1f} %"),
            _claim(f"beam, {text}: frequency within 2 %", frequency <= 0.02, f"{100 * frequency:.1f} %"),
            _claim(f"beam, {text}: decrement within 15 %", decrement <= 0.15, f"{100 * decrement:.1f} %"),
        ]
    known = f"{100 * modulus:.1f} %, {1e-3 * relaxed:.0f} kPa"
    return [*claims, _claim("beam: modulus once creep is over within 10 % of the published", modulus <= 0.1, known)]


def _relaxed_modulus(found: Identified) -> float:
    finger = found.model.finger
    return float(finger.base.youngs_modulus) * (1 - sum(branch.share for branch in finger.creep))


def _of_segment(found: Identified) -> list[Claim]:
    fitted = found.fit.root_mean_square
    turn = _worst(found, _off_turn)
    creep = _worst(found, lambda row: _off(row.simulated_creep_deg, row.creep_deg))
    recovery = _worst(found, lambda row: _off(row.simulated_recovery_deg, row.recovery_deg))
    rise = _worst(found, _off_rise)
    tip = _worst(found, lambda row: row.tip_error_percent)
    return [
        _claim("segment: fit better than 4 %", fitted <= 0.04, f"{100 * fitted:.2f} %"),
        _claim("segment: settled turn within 10 %", turn <= 0.1, f"{100 * turn:.1f} %"),
        _claim("segment: times to 50 and 63 % of it within 15 %", rise <= 0.15, f"{100 * rise:.0f} %"),
        _claim("segment: creep within 20 %", creep <= 0.2, f"{100 * creep:.0f} %"),
        _claim("segment: recovery within 15 %", recovery <= 0.15, f"{100 * recovery:.0f} %"),
        _claim("segment: tip within 5 % of the length at all times", tip <= 5, f"{tip:.1f} %"),
    ]


def _of_arm(table: Sequence[ReplayRow]) -> list[Claim]:
    tip = table[-1].body
    of = {(row.estimator, row.sections): row for row in table if (row.recording, row.body) == (ALL, tip)}
    (longest,) = (
        row for row in table if (row.estimator, row.sections, row.recording, row.body) == ("arcs", 2, _LONGEST, tip)
    )
    arcs, late, gaussian = of["arcs", 2].mean_mm, of["arcs", 2].percentile_95_mm, of["gaussian", 1].mean_mm
    ratio = max(of["gaussian", count].mean_mm / of["arcs", count].mean_mm for count in (1, 2))
    far, within = longest.mean_mm, longest.within_band_percent
    return [
        _claim("arm: two arcs find the tip within 3 mm (mean)", arcs <= 3.0, f"{arcs:.2f} mm"),
        _claim("arm: two arcs find the tip within 6 mm (95th percentile)", late <= 6.0, f"{late:.2f} mm"),
        _claim("arm: the same within 5 mm (mean) where a section is longer than fitted", far <= 5.0, f"{far:.2f} mm"),
        _claim("arm: there, the band holds 90 % of the samples", within >= 90, f"{within:.1f} %"),
        _claim("arm: gaussian, one sensor per side, within 10 mm (mean)", gaussian <= 10.0, f"{gaussian:.2f} mm"),
        _claim("arm: gaussian never worse than arcs (mean)", ratio <= 1.0, f"{ratio:.2f} times"),
    ]


def _worst(found: Identified, error: Callable[[MotionScore], float], role: str = TESTED) -> float:
    """Over the recordings of a role; NaN if one is."""
    return float(np.max([error(row) for row in found.scores if row.role == role]))


def _off_turn(row: MotionScore) -> float:
    return _off(row.simulated_settled_turn_deg, row.settled_turn_deg)


def _off_rise(row: MotionScore) -> float:
    times = (row.simulated_t50_ms, row.t50_ms), (row.simulated_t63_ms, row.t63_ms)
    return float(np.max([_off(*of) for of in times]))


def _off(simulated: float, measured: float) -> float:
    """Relative."""
    return abs(simulated / measured - 1)


def _claim(text: str, holds: bool, number: str) -> Claim:
    return Claim("ours", text, bool(holds), number)


_COLORS = {FITTED: "#2166ac", TESTED: "#b2182b", UNHELD: "#e08214"}
_LABELS = {FITTED: "simulated, fitted to it", TESTED: "simulated, held out", UNHELD: "held out, hold unknown"}
_TRIAL = "trial_2"  # its sections bend in opposite directions
_DRAWN = {"arcs 2": "arcs, 2 sensors per side", "gaussian 1": "gaussian, 1 sensor per side"}
_TURNS = (1, 2, 5, 10, 20, 50, 100)  # degrees


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


def _draw_beam(axes: Axes, found: Identified) -> None:
    for motion, row in zip(found.motions, found.scores, strict=True):
        mass = "own weight" if motion.load is None else f"{1e3 * motion.load.mass:.0f} g"
        _draw(axes, found, motion, row.role, lambda markers, m: 1e3 * displacement(markers, m), (1.45, mass))
    axes.set(xlim=(-0.1, 2.0), ylim=(-2, 58), xlabel="time since release [s]")
    axes.set_ylabel("displacement of the tip [mm]")
    axes.set_title("Silicone beam, released", loc="left")


def _draw_segment(axes: Axes, found: Identified) -> None:
    for motion, row in zip(found.motions, found.scores, strict=True):
        assert motion.pressure is not None
        pressure = f"{1e-3 * motion.pressure:.0f} kPa"
        _draw(
            axes, found, motion, row.role, lambda markers, m: np.degrees(turned(markers, m.reference)), (1.2, pressure)
        )
    axes.set(yscale="log", ylim=(_TURNS[0], _TURNS[-1]), xlim=(-0.1, 5.0), xlabel="time since the valve opened [s]")
    axes.set_yticks(_TURNS, [str(turn) for turn in _TURNS])
    axes.minorticks_off()
    axes.set_ylabel("turn of the tip [degrees]")
    axes.set_title("Pneumatic segment, pressure steps", loc="left")


def _draw(
    axes: Axes,
    found: Identified,
    motion: MeasuredMotion,
    role: str,
    value: Callable[[Planar, MeasuredMotion], Array],
    label: tuple[float, str],
) -> None:
    """A value of one recording since its event, measured and simulated, with a label at a given time."""
    time, (at, text) = motion.time - motion.events[0], label
    labelled = axes.get_legend_handles_labels()[1]
    measured, simulated = (
        value(markers, motion)
        for markers in (motion.markers, simulated_markers(found.model.finger, found.model.setup, motion))
    )
    axes.plot(time, measured, **{**MEASURED, "label": "" if labelled else MEASURED["label"]})
    axes.plot(time, simulated, color=_COLORS[role], lw=1.2, label="" if _LABELS[role] in labelled else _LABELS[role])
    place = (at, float(np.interp(at, time, measured)))
    axes.annotate(text, place, (0, 9), textcoords="offset points", color=_COLORS[role], fontsize=8)


def _draw_arm(axes: Axes, arm: ArmReplay) -> None:
    """The position of the tip across the arm."""
    signals = next(one.signals for one in arm.replayed if one.name == _TRIAL)
    tip = 1e3 * signals["measured_bodies"][1:, -1, 0]
    axes.plot(tip["time"], tip, **MEASURED)
    for (row, label), color in zip(_DRAWN.items(), ESTIMATOR_COLORS[1:], strict=False):
        axes.plot(tip["time"], 1e3 * signals[f"{row}.body_positions"][1:, -1, 0], color=color, lw=1.2, label=label)
    axes.set(xlabel="time [s]", ylabel="tip, across the arm [mm]")
    axes.set_title("Arm of two segments, estimated (trial 2)", loc="left")
