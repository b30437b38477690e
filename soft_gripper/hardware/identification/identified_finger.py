"""Recordings of hardware -> the parameters of a finger, their confidence, and their predictions."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.hardware.identification.fit import (
    Confidence,
    Fit,
    MotionScore,
    Report,
    confidence,
    converged,
    fit,
    fit_events,
    score,
)
from soft_gripper.hardware.identification.free_parameters import Model, free_parameters
from soft_gripper.hardware.identification.simulated_motion import MeasuredMotion, simulated_markers, turned
from soft_gripper.pictures.style import STYLE

_JITTER = 2.0  # typical changes, standard deviation of the random restarts


@dataclass(frozen=True)
class Identified:
    """The result."""

    fit: Fit
    confidence: Confidence
    motions: tuple[MeasuredMotion, ...]  # those fitted, then those held out, with their events
    scores: tuple[MotionScore, ...]  # of the same

    @property
    def model(self) -> Model:
        """The finger in its set-up."""
        return self.fit.model


def identify(
    finger: Finger,
    names: Sequence[str],
    fitted: Sequence[MeasuredMotion],
    tested: Sequence[MeasuredMotion],
    executor: Executor,
    starts: int = 1,
    seed: int = 0,
    report: Report = lambda error: None,
) -> Identified:
    """Fits keys of a finger to recordings, and tests the result on others.

    Args:
        finger: initial guess of the fit.
        names: the free keys, see `free_parameters`.
        fitted: recordings to fit to.
        tested: held-out recordings, of which only the times of their events are fitted.
        executor: runs the simulations.
        starts: number of fits, of which the best is kept; the first starts from the finger, the others near it.
        seed: seed of the random starts.
        report: called with the root mean square error after each step, relative to the largest displacement.

    Raises:
        InputError: if a key cannot be fitted, or no fit converges.
    """
    pressures = [motion.pressure for motion in fitted if motion.pressure is not None]
    free = free_parameters(finger, names, pressures)
    jitter = np.random.default_rng(seed).normal(size=(starts, len(free.start))) * _JITTER * free.scales
    jitter[0] = 0.0
    fits = converged(lambda away: fit(free, fitted, executor, report, free.start + away), list(jitter))
    best = min(fits, key=lambda found: found.root_mean_square)
    calls = [(best.model, motion, "fit") for motion in best.motions] + [(best.model, m, "test") for m in tested]
    scored = [future.result() for future in [executor.submit(_score, *call) for call in calls]]
    return Identified(best, confidence(best), *(tuple(column) for column in zip(*scored, strict=True)))


def _score(model: Model, motion: MeasuredMotion, role: str) -> tuple[MeasuredMotion, MotionScore]:
    timed = fit_events(model, motion) if role == "test" else motion
    return timed, score(model, timed, role)


MEASURED: dict[str, Any] = {"color": "0.6", "lw": 3.0, "label": "measured", "solid_capstyle": "round"}
SIMULATED: dict[str, Any] = {"color": "#b2182b", "lw": 1.1, "label": "simulated"}
_WIDTH, _HEIGHT = 2.6, 2.1  # inches, of a panel


def identify_figure(found: Identified) -> Figure:
    """Plots displacement and rotation of the tip, with a column for each recording."""
    roles = [score.role for score in found.scores]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            2,
            len(roles),
            figsize=(max(_WIDTH * len(roles), 5.0), 2 * _HEIGHT),
            sharex="col",
            squeeze=False,
            constrained_layout=True,
        )
        for column, motion, role in zip(axes.T, found.motions, roles, strict=True):
            draw_motion(column, found.model, motion)
            column[0].set_title(f"{motion.name}\n{'fitted' if role == 'fit' else 'held out'}")
            column[1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel("displacement of the tip [mm]")
        axes[1, 0].set_ylabel("turn of the tip [degrees]")
        axes[0, 0].legend(frameon=False)
    plt.close(figure)
    return figure


def draw_motion(axes: Sequence[Any], model: Model, motion: MeasuredMotion) -> None:
    """One recording: displacement and turn, measured and simulated."""
    simulated = simulated_markers(model.finger, model.setup, motion)
    for markers, style in ((motion.markers, MEASURED), (simulated, SIMULATED)):
        axes[0].plot(motion.time, 1e3 * displacement(markers, motion), **style)
        axes[1].plot(motion.time, np.degrees(turned(markers, motion.reference)), **style)


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
        _child(element, "pressure_law").set("pressure", _text(*law.pressure))
        _child(element, "pressure_law").set("effective", _text(*law.effective))
    ET.indent(robot)
    before_root = _PROLOG.match(text)
    assert before_root is not None
    text = before_root[0] + ET.tostring(robot, encoding="unicode") + "\n"
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        written = Path(folder) / path.name
        written.write_text(text, encoding="utf-8")
        read_finger(written)  # checks that the result is valid
    return text


def write_finger(path: Path, text: str) -> None:
    """Writes the text of a finger file, whole."""
    with atomic_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _set(element: ET.Element, name: str, value: float, before: float | None) -> None:
    if value != before and not (before is None and value == 0):
        element.set(name, _text(value))


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child


def _text(*values: float) -> str:
    return " ".join(f"{value:.6g}" for value in values)
