"""Makes the tables of docs/verification.md. Another table is a `DocTable` in TABLES, with a function of its rows."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from kirchhoff_rod import finger_tip
from published_rods import published_releases, published_shapes, release_errors, rod, shape_errors
from pushed_fingers import bent, compliance, with_cloth

from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from studies.verification.grasps import GRASPS, SPATIAL, run

RODS = ("tpu", "steel")
MIN_LOST_COMPLIANCE = 1e3  # mm/N, of an object that is pushed out of the grasp

Row = tuple[str, list[float]]  # cells of text, and then the numbers


class DocTable(NamedTuple):
    """A table; it has no rows if its data are missing."""

    header: str
    digits: tuple[int, ...]  # behind the point, in every column of numbers
    rows: Callable[[], Iterator[Row]]

    def to_markdown(self) -> str:
        """Table in Markdown."""
        lines = [f"| {self.header} |", "|---" * (self.header.count("|") + 1 - len(self.digits)) + "|"]
        lines[1] += "---:|" * len(self.digits)
        for text, numbers in self.rows():
            cells = (_cell(number, digits) for number, digits in zip(numbers, self.digits, strict=True))
            lines.append(f"| {text} | {' | '.join(cells)} |")
        return "\n".join(lines)


def _cell(number: float, digits: int) -> str:
    return "lost" if number > MIN_LOST_COMPLIANCE else f"{number:z.{digits}f}"


def shipped_finger() -> Finger:
    """Finger of models/grippers/finger.urdf."""
    return expand_urdf(DIRECTORY / "grippers" / "finger.urdf").fingers[0]


def _resting_rods() -> Iterator[Row]:
    for name in RODS:
        shapes = published_shapes(name)
        if shapes is not None:
            errors = [100 * shape_errors(rod(name, links), shapes) for links in (6, 12, 24, 48)]
            order = np.log2(errors[0].mean() / errors[1].mean())  # the files are rounded to 0.1 mm: 0.02 %
            yield name, [*(error.mean() for error in errors), np.percentile(errors[2], 95), order]


def _released_rods() -> Iterator[Row]:
    for name in RODS:
        errors = [100 * release_errors(name, 24, release).mean() for release in published_releases(name)]
        if errors:
            yield name, [np.mean(errors), min(errors), max(errors)]


def _bent_fingers() -> Iterator[Row]:
    finger = shipped_finger()
    for pressure, force in ((0.0, 0.3), (60e3, 0.3), (60e3, 1.0), (150e3, 0.3)):
        exact_tip = finger_tip(finger, pressure, (0, force, 0))
        tips = [bent(finger, segments, pressure, (0, force, 0))[1] for segments in (6, 12, 24)]
        errors = 1e3 * np.linalg.norm(tips - exact_tip, axis=1)
        deflection = 1e3 * abs(exact_tip[1])
        yield f"{pressure / 1e3:.0f} kPa, {force} N", [deflection, *errors, np.log2(errors[1] / errors[2])]


def _three_rods() -> Iterator[Row]:
    """Yields tips of a finger with a constant section, by independent solvers."""
    if find_spec("elastica") is not None:
        from studies.verification import elastica_rod

        finger, force = replace(shipped_finger(), tip=shipped_finger().base), np.array([0, 0.3, 0])
        for pressure in (60e3, 150e3):
            tips = {
                "PyElastica": elastica_rod.tip(finger, pressure, force),
                "Kirchhoff rod": finger_tip(finger, pressure, force),
                "chain of 24 segments": bent(finger, 24, pressure, force)[1],
            }
            for name, tip in tips.items():
                yield f"{pressure / 1e3:.0f} kPa | {name}", [*(1e3 * tip)]


def _compliances() -> Iterator[Row]:
    finger, pressures = shipped_finger(), (0.0, 60e3, 100e3, 150e3)
    yield "sideways, film", [compliance(finger, pressure, 1) for pressure in pressures]
    yield "sideways, cloth", [compliance(with_cloth(finger), pressure, 1) for pressure in pressures]
    yield "in its plane", [compliance(finger, pressure, 0) for pressure in pressures]


def _grasps() -> Iterator[Row]:
    for name, grasp in GRASPS.items():
        for yields in ("bending", SPATIAL):
            o = run(grasp, yields).outcome
            kind = "spatial" if yields == SPATIAL else "planar"
            yield f"{name} | {kind}", [o.lifted, o.tilt, o.force, o.friction, o.compliance]


RESTING_RODS = DocTable(
    "rod | 6 links | 12 | 24 | 48 | 95th percentile, 24 | order, 6 to 12", (2, 3, 3, 3, 3, 2), _resting_rods
)
RELEASED_RODS = DocTable("rod | mean of all releases | best | worst", (3, 3, 3), _released_rods)
BENT_FINGERS = DocTable("at the tip | sideways [mm] | 6 segments | 12 | 24 | order", (2, 2, 3, 3, 2), _bent_fingers)
SOLVERS = DocTable("pressure | solver | x [mm] | y [mm] | z [mm]", (2, 2, 2), _three_rods)
COMPLIANCE = DocTable("[mm/N] | 0 kPa | 60 kPa | 100 kPa | 150 kPa", (1, 1, 1, 1), _compliances)
GRASP_TABLE = DocTable(
    "object | fingers | yaw in the air [°] | tilt [°] | normal force [N] | friction used | gives [mm/N]",
    (1, 1, 2, 2, 2),
    _grasps,
)
TABLES = (RESTING_RODS, RELEASED_RODS, BENT_FINGERS, SOLVERS, COMPLIANCE, GRASP_TABLE)
