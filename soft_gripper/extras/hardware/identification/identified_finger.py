"""Recordings of hardware -> the parameters of a finger, their confidence, and their predictions.

A fit of a pressure law begins with the law that the settled turns of the recordings give, whatever the finger's file
says: from a law that is far off, a fit can end where valve and creep make up for it.

What was fitted of the set-up is saved beside the finger, and read again with it.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import yaml
from matplotlib.figure import Figure
from tqdm import tqdm

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.hardware.identification.confidence import Confidence
from soft_gripper.extras.hardware.identification.fit import (
    UNHELD,
    MotionScore,
    confidence,
    fit,
    fit_unknowns,
    score,
    tip_turn,
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
from soft_gripper.extras.hardware.identification.settled_states import IdentifiedStates, slack_tendons
from soft_gripper.extras.hardware.identification.simulated_motion import (
    Hold,
    MeasuredMotion,
    Setup,
    simulated_markers,
    turned,
)
from soft_gripper.extras.hardware.least_squares import Report, no_report
from soft_gripper.extras.hardware.progress import wait_for
from soft_gripper.extras.hardware.scoring import FITTED, TESTED
from soft_gripper.files.document import load_config, require
from soft_gripper.files.notes import LEFT_OUT, note
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.pictures.style import STYLE

_JITTER = 2.0  # typical changes, standard deviation of the random restarts
_MARGINS_TRIED = 200  # of a pressure law, between the least and the largest
_END_OF_RANGE = 0.02  # typical changes, within which a value is at an end of its range


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
    free = free_parameters(finger, names, pressures, _of_recordings(setup or Setup(), fitted))
    if free.model.setup.held_pose:
        where, releases = "identify", [motion.name for motion in fitted if motion.pressure is None]
        require(len(releases) > 0, where, "--free", HELD_POSE, "no hand lets go in these recordings")
    if PRESSURE_LAW in names:
        free = replace(free, model=replace(free.model, finger=_with_static_law(free.model.finger, fitted)))
    fitted = [as_held(free.model.setup, motion) for motion in fitted]
    best = fit(free, fitted, executor.map, report, free.starts(starts, seed, _JITTER))
    calls = [(best.model, motion, FITTED) for motion in best.recordings] + _tests(best.model, tested)
    return Identified(best.model, *_scored(calls, executor), best, confidence(best))


def compared(model: Model, motions: Sequence[MeasuredMotion], executor: Executor) -> Tested:
    """Compares recordings with a finger in its set-up; only what was not recorded is fitted to them."""
    return Tested(model, *_scored(_tests(model, motions), executor))


def _tests(model: Model, motions: Sequence[MeasuredMotion]) -> list[tuple[Model, MeasuredMotion, str]]:
    """Comparisons with held-out recordings: with the held pose that explains each best, and without."""
    held = [motion for motion in motions if as_held(model.setup, motion).hold is not None]
    return [(model, motion, TESTED) for motion in motions] + [(model, motion, UNHELD) for motion in held]


def _of_recordings(setup: Setup, motions: Sequence[MeasuredMotion]) -> Setup:
    """A set-up with the ranges of the recordings that are fitted."""
    pressure = max(motion.pressure or 0.0 for motion in motions)
    load = max(motion.load.mass if motion.load else 0.0 for motion in motions)
    return replace(setup, highest_pressure=pressure, heaviest_load=load)


def _with_static_law(finger: Finger, motions: Sequence[MeasuredMotion]) -> Finger:
    """A finger with the pressure law that the settled turns give, weight left out."""
    steps = [motion for motion in motions if motion.pressure is not None]
    pressures = np.array([motion.pressure for motion in steps])
    turns = np.array([tip_turn(motion, motion.markers).settled for motion in steps])
    per_pressure, highest = np.log(np.abs(turns / pressures)), float(pressures.max())
    least, most = (float(np.log(end)) for end in MARGINS)
    margins = np.exp(np.linspace(least, most, _MARGINS_TRIED)) if len(set(pressures)) > 1 else np.ones(1)
    excess = per_pressure + np.log(1 - (1 - margins[:, None]) * pressures / highest)
    best = int(np.argmin(excess.std(axis=1)))
    remains = 1 - sum(branch.share for branch in finger.creep)
    of_chamber = float(np.sum(finger.pressure_gain / finger.stiffness)) / remains
    gain = float(np.exp(excess[best].mean())) / of_chamber
    margin = 1 - remains * (1 - float(margins[best]))  # before creep, which takes a part of the stiffness as pressure
    return replace(finger, pressure_law=pressure_law(highest, gain, margin))


def as_held(setup: Setup, motion: MeasuredMotion) -> MeasuredMotion:
    """A recording whose held pose is to be fitted, if the set-up says so and a hand lets go in it."""
    return replace(motion, hold=Hold()) if setup.held_pose and motion.pressure is None else motion


def _scored(
    calls: Sequence[tuple[Model, MeasuredMotion, str]], executor: Executor
) -> tuple[tuple[MeasuredMotion, ...], tuple[MotionScore, ...]]:
    """Recordings with what was not recorded, and their scores; one in which the finger diverges is left out."""
    pending = [executor.submit(_score, model, motion, role) for model, motion, role in calls]
    wait_for(pending, "comparing", "recording")
    motions, scores = list[MeasuredMotion](), list[MotionScore]()
    for (_, compared, _), future in zip(calls, pending, strict=True):
        try:
            motion, row = future.result()
        except SimulationDivergedError as error:
            note(LEFT_OUT, compared.name, "recording", "", str(error))
            continue
        motions.append(motion)
        scores.append(row)
    return tuple(motions), tuple(scores)


# Of the tip, in a recording that was fitted, of a good fit
_LARGEST_GOOD_ERROR = 5.0  # % of the finger's length


def doubts(tested: Tested) -> list[str]:
    """Why not to trust a result: keys at an end of their range, a bad fit, recordings beyond those that were fitted."""
    setup = tested.model.setup
    said = doubts_of_fit(tested.fit, tested.confidence) if isinstance(tested, Identified) else []
    for row, motion in zip(tested.scores, tested.motions, strict=True):
        if row.role == FITTED and row.tip_error_percent > _LARGEST_GOOD_ERROR:
            error = f"{row.tip_error_percent:.1f} % of the length"
            said.append(
                f"{row.recording} was fitted, and the tip is off by up to {error}: try --starts 5, or more keys"
            )
        if 0 < setup.highest_pressure < (motion.pressure or 0.0):
            pressures = f"{1e-3 * (motion.pressure or 0.0):g} kPa, fitted up to {1e-3 * setup.highest_pressure:g} kPa"
            said.append(f"{row.recording} is extrapolated: {pressures}")
        if 0 < setup.heaviest_load < (motion.load.mass if motion.load else 0.0):
            assert motion.load is not None
            loads = f"{1e3 * motion.load.mass:g} g, fitted up to {1e3 * setup.heaviest_load:g} g"
            said.append(f"{row.recording} is extrapolated: {loads}")
    return list(dict.fromkeys(said))


def repetitions(tested: Tested) -> list[str]:
    """How much recordings under the same load and pressure differ, as text: what no model can be judged below."""
    alike: dict[tuple[float, ...], list[MotionScore]] = {}
    for row, motion in zip(tested.scores, tested.motions, strict=True):
        if row.role != UNHELD:
            load = (motion.load.mass, motion.load.x, motion.load.z) if motion.load else (0.0,)
            alike.setdefault((motion.pressure or 0.0, *load), []).append(row)
    return [_spread_of(rows) for rows in alike.values() if len(rows) > 1]


def _spread_of(rows: Sequence[MotionScore]) -> str:
    def between(column: str, form: str) -> str:
        values = [getattr(row, column) for row in rows]
        return f"{min(values):{form}} to {max(values):{form}}"

    names, turn = " and ".join(row.recording for row in rows), between("settled_turn_deg", ".2f")
    swing = "" if np.isnan(rows[0].decrement) else f", decrement {between('decrement', '.2f')}"
    return f"{names} repeat each other: settled turn {turn} degrees{swing}"


def doubts_of_fit(fit: FingerFit[Any], confidence: Confidence) -> list[str]:
    """Keys that are all undetermined, or at an end of their range, and a search that was ended before it converged."""
    free, x, (lower, upper) = fit.free, fit.x, fit.free.bounds
    ends = np.minimum(x - lower, upper - x) < _END_OF_RANGE * free.scales
    said = []
    if not confidence.names:
        said.append("no key is determined: the values at which the search ended predict what is left out, too")
    said += [
        f"{name} ends at {value:.3g}, a bound of its range: fix it, or try --starts 5"
        for name, value in zip(np.array(free.names)[ends], free.values(x)[ends], strict=True)
        if name in confidence.names
    ]
    if not fit.converged:
        said.append("the search was ended before it converged: go on from the finger that it wrote, or free fewer keys")
    return said


def doubts_of_states(identified: IdentifiedStates) -> list[str]:
    """Doubts of a fit to settled states, and tendons that no row tightens."""
    slack = slack_tendons(identified.model, identified.states[: len(identified.left_out)])
    said = f"no row tightens {', '.join(slack)}: do they pull the other way?"
    return doubts_of_fit(identified.fit, identified.confidence) + ([said] if slack else [])


def _score(model: Model, motion: MeasuredMotion, role: str) -> tuple[MeasuredMotion, MotionScore]:
    if role != FITTED:
        motion = fit_unknowns(model, as_held(model.setup, motion) if role == TESTED else motion)
    return motion, score(model, motion, role)


MEASURED: dict[str, Any] = {"color": "0.6", "lw": 3.0, "label": "measured", "solid_capstyle": "round"}
SIMULATED: dict[str, Any] = {"color": "#b2182b", "lw": 1.1, "label": "simulated"}
_WIDTH, _HEIGHT = 2.6, 2.1  # inches, of a panel
_TITLES = {FITTED: "fitted", TESTED: "held out", UNHELD: "held out, hold unknown"}


def identify_figure(tested: Tested) -> Figure:
    """Plots displacement and rotation of the tip, with a column for each recording."""
    roles = [score.role for score in tested.scores]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            2,
            len(roles),
            figsize=(max(_WIDTH * len(roles), 5.0), 2 * _HEIGHT),
            sharex="col",
            squeeze=False,
            constrained_layout=True,
        )
        motions = tqdm(tested.motions, desc="figure", unit="recording", dynamic_ncols=True)
        for column, motion, role in zip(axes.T, motions, roles, strict=True):
            simulated = simulated_markers(tested.model.finger, tested.model.setup, motion)
            for markers, style in ((motion.markers, MEASURED), (simulated, SIMULATED)):
                column[0].plot(motion.time, 1e3 * displacement(markers, motion), **style)
                column[1].plot(motion.time, np.degrees(turned(markers, motion.reference)), **style)
            column[0].set_title(f"{motion.name}\n{_TITLES[role]}")
            column[1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel("tip displaced by [mm]")
        axes[1, 0].set_ylabel("tip turned by [degrees]")
        axes[0, 0].legend(frameon=False)
    plt.close(figure)
    return figure


def displacement(markers: Planar, motion: MeasuredMotion) -> Array:
    """Displacement of the marker centre from its place before the event, m, (T,)."""
    distance: Array = np.abs(np.mean(markers - motion.reference, axis=1))
    return distance


_PROLOG = re.compile(r"(?:\s|<\?.*?\?>|<!--.*?-->)*", re.DOTALL)  # may precede the root element
_OF_BODY = ("length", "relaxation_time", "shear_factor")
_OF_SECTION = ("youngs_modulus", "density", "chamber_width", "chamber_thickness", "layer_shear_modulus")


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
    """The text of a finger file with the numbers of another finger; comments and everything else are kept.

    Raises:
        InputError: if the result is not a valid finger file.
    """
    text = read_text(path)
    robot = parse_xml(path, text)
    element = robot.find("finger")
    assert element is not None
    before = read_finger(path)
    for name in _OF_BODY:
        _set(_child(element, "body"), name, getattr(finger, name), getattr(before, name))
    sections = [*element.findall("base"), *element.findall("section"), *element.findall("tip")]
    for section, part, part_before in zip(sections, finger.cross_sections, before.cross_sections, strict=True):
        is_other = (part.youngs_modulus, part.density) != (part_before.youngs_modulus, part_before.density)
        if is_other:
            section.attrib.pop("material", None)  # it applied to both
        for name in _OF_SECTION:
            _set(section, name, getattr(part, name), None if is_other else getattr(part_before, name))
    for child, tendon, given in zip(element.findall("tendon"), finger.tendons, before.tendons, strict=True):
        if (tendon.x, tendon.y) != (given.x, given.y):
            child.set("x", _text(*tendon.x))
            child.set("y", _text(*tendon.y))
        _set(child, "stiffness", tendon.stiffness, given.stiffness)
        _set(child, "slack", tendon.slack, given.slack)
    if finger.creep != before.creep:
        for name in ("share", "time"):
            _child(element, "creep").set(name, _text(*(getattr(branch, name) for branch in finger.creep)))
    law = finger.pressure_law
    if law is not None and law != before.pressure_law:
        for name in ("pressure", "effective", "stiffness_taken"):
            _child(element, "pressure_law").set(name, _text(*getattr(law, name)))
    ET.indent(robot)
    before_root = _PROLOG.match(text)
    assert before_root is not None
    text = before_root[0] + ET.tostring(robot, encoding="unicode") + "\n"
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        written = Path(folder) / path.name
        written.write_text(text, encoding="utf-8")
        read_finger(written)  # checks that the result is valid
    return text


def fit_remarks(confidence: Confidence) -> list[str]:
    """Remarks on a fit, for the file of its set-up."""
    return [
        f"Fitted: {', '.join(confidence.names) or 'nothing, since no key is determined'}",
        *map(str, confidence.undetermined),
    ]


def write_fitted(initial: Path, path: Path, model: Model, remarks: Sequence[str] = ()) -> None:
    """Writes a fitted finger, by the file of its initial guess, and its set-up beside it; each file is always whole.

    Raises:
        InputError: if a file cannot be written, or the finger's would not be valid.
    """
    for file, text in (
        (setup_file(path), setup_text(model.setup, remarks)),
        (path, with_finger(initial, model.finger)),
    ):
        with atomic_file(file) as partial:
            partial.write_text(text, encoding="utf-8")


def setup_file(finger: Path) -> Path:
    """Where the set-up of a finger's recordings is saved, beside its file."""
    return finger.with_suffix(".setup.yaml")


def read_setup(finger: Path) -> Setup:
    """The set-up that is saved beside a finger's file; the default if there is none.

    Raises:
        InputError: if it cannot be read, or a field is wrong.
    """
    file = setup_file(finger)
    return load_config(file, read_yaml(file), Setup) if file.exists() else Setup()


def setup_text(setup: Setup, remarks: Sequence[str] = ()) -> str:
    """The text of a set-up's file, with remarks on the fit in its head."""
    title = "The set-up of the recordings that a finger was identified from, for `soft-gripper identify --test`"
    head = "".join(f"# {line}\n" for line in (title, *remarks))
    text: str = yaml.safe_dump(asdict(setup), sort_keys=False)
    return head + text


def _set(element: ET.Element, name: str, value: float, before: float | None) -> None:
    if value != before and not (before is None and value == 0):
        element.set(name, _text(value))


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child


def _text(*values: float) -> str:
    return " ".join(f"{value:.6g}" for value in values)
