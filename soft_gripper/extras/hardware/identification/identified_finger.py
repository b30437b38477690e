"""Recordings of hardware -> the parameters of a finger, their confidence, and their predictions.

A fit of a pressure law begins with the law that the settled turns of the recordings give, whatever the finger's file
says: from a law that is far off, a fit can end where valve and creep make up for it.

What was fitted of the set-up is saved beside the finger, and read again with it.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.hardware.identification.companion_file import CompanionFile
from soft_gripper.extras.hardware.identification.confidence import Confidence, fit_doubts
from soft_gripper.extras.hardware.identification.fit import (
    UNHELD,
    MotionScore,
    fit,
    fit_confidence,
    fit_unknowns,
    score,
    turn_response,
)
from soft_gripper.extras.hardware.identification.free_parameters import (
    HELD_POSE,
    MARGINS,
    PRESSURE_LAW,
    FingerFit,
    Model,
    free_parameters,
    pressure_law,
)
from soft_gripper.extras.hardware.identification.simulated_motion import (
    Hold,
    MeasuredMotion,
    Setup,
    marker_rotation,
    simulated_markers,
)
from soft_gripper.extras.hardware.least_squares import Report, no_report
from soft_gripper.extras.hardware.progress import wait_for
from soft_gripper.extras.hardware.scoring import FITTED, TESTED
from soft_gripper.files.document import require
from soft_gripper.files.notes import LEFT_OUT, note
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.pictures.style import STYLE

_JITTER = 2.0  # typical changes, standard deviation of the random restarts
_MARGINS_TRIED = 200  # of a pressure law, between the least and the largest
SETUP = CompanionFile(
    ".setup.yaml",
    "The set-up of the recordings that a finger was identified from, for `soft-gripper identify --test`",
    Setup,
)


@dataclass(frozen=True)
class Tested:
    """Recordings compared with a finger."""

    model: Model  # the finger in its set-up
    motions: tuple[MeasuredMotion, ...]  # with what was not recorded, as fitted
    scores: tuple[MotionScore, ...]  # of the same


@dataclass(frozen=True)
class Identified(Tested):
    """The result of a fit: the recordings that were fitted, then those held out."""

    fit: FingerFit[MeasuredMotion]
    confidence: Confidence


def identify(
    finger: Finger,
    names: Sequence[str],
    fitted: Sequence[MeasuredMotion],
    tested: Sequence[MeasuredMotion],
    executor: Executor,
    starts: int = 1,
    seed: int = 0,
    report: Report = no_report,
    setup: Setup | None = None,
) -> Identified:
    """Fits keys of a finger to recordings, and tests the result on others.

    Args:
        finger: initial guess of the fit.
        names: the free keys, see `free_parameters`.
        fitted: recordings to fit to.
        tested: held-out recordings, of which only the times of their events are fitted and, if it is free, the held
            pose; those with a held pose are compared a second time without it.
        executor: runs the simulations.
        starts: number of fits, of which the best is kept; the first starts from the finger, the others near it.
        seed: seed of the random starts.
        report: called after each step of a search.
        setup: initial guess of the set-up; None: the default.

    Raises:
        InputError: if a key cannot be fitted, or no fit comes near the markers.
    """
    pressures = [motion.pressure for motion in fitted if motion.pressure is not None]
    free = free_parameters(finger, names, pressures, _with_ranges(setup or Setup(), fitted))
    if free.model.setup.held_pose:
        is_released = any(motion.pressure is None for motion in fitted)
        require(is_released, "identify", "--free", HELD_POSE, "no hand lets go in these recordings")
    if PRESSURE_LAW in names:
        free = replace(free, model=replace(free.model, finger=_with_static_law(free.model.finger, fitted)))
    motions = [_with_hold(free.model.setup, motion) for motion in fitted]
    best_fit = fit(free, motions, executor.map, report, free.starts(starts, seed, _JITTER))
    scores = _scores(best_fit.model, best_fit.recordings, tested, executor)
    return Identified(best_fit.model, *scores, best_fit, fit_confidence(best_fit))


def compare_motions(model: Model, motions: Sequence[MeasuredMotion], executor: Executor) -> Tested:
    """Compares recordings with a finger in its set-up; fits only their unrecorded quantities."""
    return Tested(model, *_scores(model, [], motions, executor))


def _with_ranges(setup: Setup, motions: Sequence[MeasuredMotion]) -> Setup:
    """Copy of a set-up with the ranges of the fitted recordings."""
    pressure = max(motion.pressure or 0.0 for motion in motions)
    load = max(motion.load.mass if motion.load else 0.0 for motion in motions)
    return replace(setup, highest_pressure=pressure, heaviest_load=load)


def _with_static_law(finger: Finger, motions: Sequence[MeasuredMotion]) -> Finger:
    """Copy of a finger with the pressure law estimated from the settled rotations, without weight."""
    steps = [motion for motion in motions if motion.pressure is not None]
    pressures = np.array([motion.pressure for motion in steps])
    settled_turns = np.array([turn_response(motion, motion.markers).settled for motion in steps])
    log_rates, highest_pressure = np.log(np.abs(settled_turns / pressures)), float(pressures.max())
    min_log, max_log = (float(np.log(end)) for end in MARGINS)
    margins = np.exp(np.linspace(min_log, max_log, _MARGINS_TRIED)) if len(set(pressures)) > 1 else np.ones(1)
    excess = log_rates + np.log(1 - (1 - margins[:, None]) * pressures / highest_pressure)
    index = int(np.argmin(excess.std(axis=1)))
    lasting_share = 1 - sum(branch.share for branch in finger.creep)
    chamber_rate = float(np.sum(finger.pressure_gain / finger.stiffness)) / lasting_share
    gain = float(np.exp(excess[index].mean())) / chamber_rate
    margin = 1 - lasting_share * (1 - float(margins[index]))  # before creep, which takes stiffness as pressure does
    return replace(finger, pressure_law=pressure_law(highest_pressure, gain, margin))


def _with_hold(setup: Setup, motion: MeasuredMotion) -> MeasuredMotion:
    """Copy of a recording with a held pose to fit, if the set-up asks for it and a hand lets go in it."""
    return replace(motion, hold=Hold()) if setup.held_pose and motion.pressure is None else motion


def _scores(
    model: Model, fitted: Sequence[MeasuredMotion], tested: Sequence[MeasuredMotion], executor: Executor
) -> tuple[tuple[MeasuredMotion, ...], tuple[MotionScore, ...]]:
    """Recordings with fitted unrecorded quantities, and their scores, without recordings in which the finger diverges.

    Those held out are compared with the held pose that explains each best, and without.
    """
    held_motions = [motion for motion in tested if _with_hold(model.setup, motion).hold is not None]
    roles = {FITTED: fitted, TESTED: tested, UNHELD: held_motions}
    calls = [(motion, role) for role, motions in roles.items() for motion in motions]
    futures = [executor.submit(_score, model, *call) for call in calls]
    wait_for(futures, "comparing", "recording")
    scores = list[tuple[MeasuredMotion, MotionScore]]()
    for (motion, _), future in zip(calls, futures, strict=True):
        try:
            scores.append(future.result())
        except SimulationDivergedError as error:
            note(LEFT_OUT, motion.name, "recording", "", str(error))
    return tuple(motion for motion, _ in scores), tuple(score for _, score in scores)


def _score(model: Model, motion: MeasuredMotion, role: str) -> tuple[MeasuredMotion, MotionScore]:
    if role != FITTED:
        motion = fit_unknowns(model, _with_hold(model.setup, motion) if role == TESTED else motion)
    return motion, score(model, motion, role)


_MAX_FITTED_ERROR = 5.0  # % of the finger's length, of the tip in a recording that was fitted well


def motion_doubts(tested: Tested) -> list[str]:
    """Warnings about a result: keys at an end of their range, a bad fit, recordings beyond the fitted ones."""
    setup = tested.model.setup
    doubts = fit_doubts(tested.fit, tested.confidence) if isinstance(tested, Identified) else []
    for row, motion in zip(tested.scores, tested.motions, strict=True):
        pressure, load = motion.pressure or 0.0, motion.load.mass if motion.load else 0.0
        if row.role == FITTED and row.tip_error_percent > _MAX_FITTED_ERROR:
            error = f"{row.tip_error_percent:.1f} % of the length"
            doubts.append(
                f"{row.recording} was fitted, and the tip is off by up to {error}: try --starts 5, or more keys"
            )
        if 0 < setup.highest_pressure < pressure:
            pressures = f"{1e-3 * pressure:g} kPa, fitted up to {1e-3 * setup.highest_pressure:g} kPa"
            doubts.append(f"{row.recording} is extrapolated: {pressures}")
        if 0 < setup.heaviest_load < load:
            loads = f"{1e3 * load:g} g, fitted up to {1e3 * setup.heaviest_load:g} g"
            doubts.append(f"{row.recording} is extrapolated: {loads}")
    return list(dict.fromkeys(doubts))


def repetitions(tested: Tested) -> list[str]:
    """Differences of recordings under the same load and pressure, as text: no model can be judged below them."""
    groups: dict[tuple[float, ...], list[MotionScore]] = {}
    for row, motion in zip(tested.scores, tested.motions, strict=True):
        if row.role != UNHELD:
            load = (motion.load.mass, motion.load.x, motion.load.z) if motion.load else (0.0,)
            groups.setdefault((motion.pressure or 0.0, *load), []).append(row)
    texts = []
    for rows in groups.values():
        names = " and ".join(row.recording for row in rows)
        turns, decrements = [row.settled_turn_deg for row in rows], [row.decrement for row in rows]
        swing = f", decrement {min(decrements):.2f} to {max(decrements):.2f}" if np.isfinite(decrements[0]) else ""
        if len(rows) > 1:
            turn_text = f"settled turn {min(turns):.2f} to {max(turns):.2f} degrees"
            texts.append(f"{names} repeat each other: {turn_text}{swing}")
    return texts


MEASURED: dict[str, Any] = {"color": "0.6", "lw": 3.0, "label": "measured", "solid_capstyle": "round"}
SIMULATED: dict[str, Any] = {"color": "#b2182b", "lw": 1.1, "label": "simulated"}
_WIDTH, _HEIGHT = 2.6, 2.1  # inches, of a panel
_TITLES = {FITTED: "fitted", TESTED: "held out", UNHELD: "held out, hold unknown"}


def identify_figure(tested: Tested) -> Figure:
    """Plots displacement and rotation of the tip, with a column for each recording."""
    roles = [score.role for score in tested.scores]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(max(_WIDTH * len(roles), 5.0), 2 * _HEIGHT), constrained_layout=True)
        axes = figure.subplots(2, len(roles), sharex="col", squeeze=False)
        motions = tqdm(tested.motions, desc="figure", unit="recording", dynamic_ncols=True)
        for column, motion, role in zip(axes.T, motions, roles, strict=True):
            simulated_positions = simulated_markers(tested.model.finger, tested.model.setup, motion)
            for markers, style in ((motion.markers, MEASURED), (simulated_positions, SIMULATED)):
                column[0].plot(motion.time, 1e3 * displacement(markers, motion), **style)
                column[1].plot(motion.time, np.degrees(marker_rotation(markers, motion.reference)), **style)
            column[0].set_title(f"{motion.name}\n{_TITLES[role]}")
            column[1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel("tip displaced by [mm]")
        axes[1, 0].set_ylabel("tip turned by [degrees]")
        axes[0, 0].legend(frameon=False)
    plt.close(figure)
    return figure


def displacement(markers: Planar, motion: MeasuredMotion) -> Array:
    """Displacement of the marker centre from its place before the event, m, (T,)."""
    return np.abs(np.mean(markers - motion.reference, axis=1))


_PROLOG = re.compile(r"(?:\s|<\?.*?\?>|<!--.*?-->)*", re.DOTALL)  # may precede the root element
_BODY_FIELDS = ("length", "relaxation_time", "shear_factor")
_SECTION_FIELDS = ("youngs_modulus", "density", "chamber_width", "chamber_thickness", "layer_shear_modulus")


def read_finger(path: Path) -> Finger:
    """The finger of a file.

    Raises:
        InputError: if the file cannot be read or does not contain exactly one finger.
    """
    fingers = expand_urdf(path).fingers
    if len(fingers) != 1:
        raise InputError(path, "finger", [finger.name for finger in fingers], "give a file with one finger")
    return fingers[0]


def with_finger(path: Path, finger: Finger) -> str:
    """The text of a finger file with the numbers of another finger; comments and everything else are kept."""
    text = read_text(path)
    robot = parse_xml(path, text)
    element = robot.find("finger")
    assert element is not None
    initial = read_finger(path)
    for name in _BODY_FIELDS:
        _set_attribute(_child_element(element, "body"), name, getattr(finger, name), getattr(initial, name))
    sections = [*element.findall("base"), *element.findall("section"), *element.findall("tip")]
    for section, part, initial_part in zip(sections, finger.cross_sections, initial.cross_sections, strict=True):
        is_other = (part.youngs_modulus, part.density) != (initial_part.youngs_modulus, initial_part.density)
        if is_other:
            section.attrib.pop("material", None)  # it applied to both
        for name in _SECTION_FIELDS:
            _set_attribute(section, name, getattr(part, name), None if is_other else getattr(initial_part, name))
    for child, tendon, initial_tendon in zip(element.findall("tendon"), finger.tendons, initial.tendons, strict=True):
        if (tendon.x, tendon.y) != (initial_tendon.x, initial_tendon.y):
            child.set("x", _text(*tendon.x))
            child.set("y", _text(*tendon.y))
        _set_attribute(child, "stiffness", tendon.stiffness, initial_tendon.stiffness)
        _set_attribute(child, "slack", tendon.slack, initial_tendon.slack)
    if finger.creep != initial.creep:
        for name in ("share", "time"):
            _child_element(element, "creep").set(name, _text(*(getattr(branch, name) for branch in finger.creep)))
    law = finger.pressure_law
    if law is not None and law != initial.pressure_law:
        for name in ("pressure", "effective", "stiffness_taken"):
            _child_element(element, "pressure_law").set(name, _text(*getattr(law, name)))
    ET.indent(robot)
    prolog = _PROLOG.match(text)
    assert prolog is not None
    text = prolog[0] + ET.tostring(robot, encoding="unicode") + "\n"
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        written_path = Path(folder) / path.name
        written_path.write_text(text, encoding="utf-8")
        read_finger(written_path)  # checks that the result is valid
    return text


def fit_remarks(confidence: Confidence) -> list[str]:
    """Remarks on a fit, for the file of its set-up."""
    key_names = ", ".join(confidence.names) or "nothing, since no key is determined"
    return [f"Fitted: {key_names}", *map(str, confidence.undetermined)]


def write_fitted(initial: Path, path: Path, model: Model, remarks: Sequence[str] = ()) -> None:
    """Writes a fitted finger, by the file of its initial guess, and its set-up beside it; each file is always whole."""
    text = with_finger(initial, model.finger)
    SETUP.write(path, model.setup, remarks)
    with atomic_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def read_setup(finger: Path) -> Setup:
    """Reads the set-up beside a finger's file; the default without such a file."""
    return SETUP.read(finger) or Setup()


def _set_attribute(element: ET.Element, name: str, value: float, initial: float | None) -> None:
    if value != initial and not (initial is None and value == 0):
        element.set(name, _text(value))


def _child_element(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child


def _text(*values: float) -> str:
    return " ".join(f"{value:.6g}" for value in values)
