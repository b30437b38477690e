"""How far markers may be from where an identified finger has them, and recordings that leave what it was fitted to.

A state is what drives the finger: how far its tendons are pulled, or the pressure of its chamber, and the load on its
tip. The band of a marker is a ball that holds it with a probability of 95 %, and grows with the distance from the
nearest fitted state, as `fitted_states` says. In motions it is a share of the largest displacement, which grows with
the drive too; what is fitted to every recording, its events, is taken as found.

The states and the band are kept beside the finger's file, and read again with it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.fit import MotionScore
from soft_gripper.extras.hardware.identification.identified_finger import Identified, Tested
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    StateScore,
    TestedStates,
)
from soft_gripper.extras.hardware.identification.simulated_motion import MeasuredMotion, simulated_markers
from soft_gripper.extras.hardware.scoring import LEFT_OUT
from soft_gripper.files.document import load_config, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig, kept_states
from soft_gripper.sensors.fitted_states import (
    FittedStates,
    LeftOut,
    learned_widths,
    moved_without,
    regions_left_out,
    spread_of,
)

_LOAD = 0.1  # kg, unit of loads: recordings often have a single one
_STRIDE = 5  # one sample of a motion in so many counts


@dataclass(frozen=True)
class BandRow:
    """Markers of a recording and their 95 % bands."""

    recording: str
    role: str
    within_band_percent: Annotated[float, ".1f"]
    band_mm: Annotated[float, ".2f"]  # mean radius
    far_percent: Annotated[float, ".1f"]  # rows, or samples, that are far from what was fitted


class _Driven(NamedTuple):
    """T rows or samples of a recording."""

    name: str
    states: Array  # (T, D)
    errors: Array  # (T, M) m, of the markers; NaN where one is not seen
    scale: float  # m, of errors: the largest displacement, or 1


def learned_band(found: Identified | IdentifiedStates) -> FittedStatesConfig:
    """The states that a finger was fitted to, and the band of its markers."""
    fit = found.fit
    if isinstance(found, IdentifiedStates):
        count = len(found.left_out)
        recordings = [*_of_states(TestedStates(found.model, found.states[:count], found.errors[:count], ()))]
        parts, to_error = 3, np.ones(1)
    else:
        assert isinstance(found, Identified)
        recordings = [*_of_motions(Tested(found.model, found.fit.motions, ()), every=1)]
        parts = 2
        sizes = [each.errors.size for each in recordings]
        to_error = np.concatenate([np.full(2 * size, np.sqrt(size)) for size in sizes]) / found.fit.weights
    states = np.concatenate([np.repeat(each.states, each.errors.shape[1], axis=0) for each in recordings])
    seen = np.concatenate([np.isfinite(each.errors).ravel() for each in recordings])
    fitted = FittedStates(states, _spreads(states))
    slopes = fit.jacobian * fit.free.scales

    def errors(moved: Array, rows: NDArray[np.bool_]) -> Array:
        away = ((fit.residuals + slopes @ moved) * to_error).reshape(-1, parts)
        size: Array = np.linalg.norm(away, axis=-1)[rows & seen, None]
        return size

    def without(region: NDArray[np.bool_]) -> LeftOut:
        moved = moved_without(slopes, fit.residuals, np.repeat(~region, parts))
        distance = fitted.without(region).distance(states[region & seen])
        return LeftOut(errors(moved, region), np.sqrt(distance)[:, None])

    everything = np.ones(len(states), bool)
    widths = learned_widths(errors(np.zeros(len(fit.x)), everything), [*regions_left_out([fitted], without)])
    return kept_states(_names(found.model.finger, states), fitted, widths)


def _names(finger: Finger, states: Array) -> list[str]:
    driven = [f"{tendon.name} [m]" for tendon in finger.tendons] or ["pressure [Pa]"]
    return [*driven[: states.shape[-1] - 1], "load [kg]"]


def _spreads(states: Array) -> Array:
    return np.append(np.full(states.shape[-1] - 1, spread_of(states[:, :-1])), _LOAD)


def band_rows(kept: FittedStatesConfig, found: Tested | TestedStates) -> list[BandRow]:
    """How the markers of recordings lie in their bands."""
    fitted, widths = kept.fitted, kept.widths
    recordings = _of_states(found) if isinstance(found, TestedStates) else _of_motions(found, _STRIDE)
    scores: Sequence[MotionScore | StateScore] = found.scores
    roles = {score.recording: score.role for score in reversed(scores)}
    rows = []
    for each in recordings:
        expected = f"its states have {each.states.shape[-1]} numbers: is it of another finger?"
        require(len(kept.spread) == each.states.shape[-1], each.name, "states", len(kept.spread), expected)
        by_distance = np.sqrt(fitted.distance(each.states))[:, None]
        band, seen = each.scale * widths.band(by_distance), np.isfinite(each.errors)
        within = 100 * float((each.errors <= band)[seen].mean())
        far = 100 * float(widths.is_far(by_distance).mean())
        rows.append(BandRow(each.name, roles[each.name], within, 1e3 * float(band.mean()), far))
    return rows + (_left_out_rows(kept, found) if isinstance(found, IdentifiedStates) else [])


def _left_out_rows(kept: FittedStatesConfig, found: IdentifiedStates) -> list[BandRow]:
    """How the markers of fitted rows lie in their bands, each by a fit without its family, and away from the others."""
    states, count = np.concatenate([_pulled(each) for each in found.states[: len(found.left_out)]]), 0
    rows = []
    for each, errors in zip(found.states, found.left_out, strict=False):
        own, count = np.arange(count, count + len(errors)), count + len(errors)
        distances = []
        for family in sorted({*each.families} - {""}):
            of_family = own[each.families == family]
            others = FittedStates(np.delete(states, of_family, axis=0), kept.fitted.spread)
            distances.append((of_family - own[0], np.sqrt(others.distance(states[of_family]))[:, None]))
        if not distances:
            continue
        at, by_distance = (np.concatenate(part) for part in zip(*distances, strict=True))
        band, size = kept.widths.band(by_distance), np.linalg.norm(errors[at], axis=-1)
        within, far = 100 * float((size <= band).mean()), 100 * float(kept.widths.is_far(by_distance).mean())
        rows.append(BandRow(each.name, LEFT_OUT, within, 1e3 * float(band.mean()), far))
    return rows


def extrapolations(rows: Sequence[BandRow]) -> list[str]:
    """Recordings that are far from what was fitted, as text."""
    return [
        f"{row.recording}: {row.far_percent:.0f} % of it is far from what was fitted"
        for row in rows
        if row.far_percent and row.role != LEFT_OUT
    ]


def _of_states(found: TestedStates) -> Iterator[_Driven]:
    for states, errors in zip(found.states, found.errors, strict=True):
        yield _Driven(states.name, _pulled(states), np.linalg.norm(errors, axis=-1), 1.0)


def _pulled(states: SettledStates) -> Array:
    return np.column_stack([states.pulled, np.full(len(states.pulled), states.load)])


def _of_motions(found: Tested, every: int) -> Iterator[_Driven]:
    """Errors of motions; of a fit as shares of the largest displacement that was measured, as it takes them."""
    for motion in {motion.name: motion for motion in reversed(found.motions)}.values():
        simulated = simulated_markers(found.model.finger, found.model.setup, motion)
        errors = np.abs(simulated - motion.markers)[::every]
        scale = float(np.abs(np.mean(simulated - motion.reference, axis=1)).max())
        yield _Driven(motion.name, np.tile(_driven(motion), (len(errors), 1)), errors, scale)


def _driven(motion: MeasuredMotion) -> Array:
    return np.array([motion.pressure or 0.0, motion.load.mass if motion.load else 0.0])


def states_file(finger: Path) -> Path:
    """Where the states that a finger was fitted to are kept, beside its file."""
    return finger.with_suffix(".states.yaml")


def states_text(kept: FittedStatesConfig) -> str:
    """The text of that file."""
    head = "# The states that a finger was fitted to, and how its errors grow away from them, for `--test`\n"
    text: str = yaml.safe_dump(asdict(kept), sort_keys=False, default_flow_style=None, width=120)
    return head + text


def read_states(finger: Path) -> FittedStatesConfig | None:
    """The states beside a finger's file; None if there are none.

    Raises:
        InputError: if they cannot be read, or a number is impossible.
    """
    file = states_file(finger)
    return load_config(file, read_yaml(file), FittedStatesConfig) if file.exists() else None
