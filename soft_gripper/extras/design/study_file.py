"""The schema of a design study: variables, objects, random draws, limits and ends; see examples/design/bottle.yaml.

Keys are dotted fields of the scenario, as after `--set`. Files are relative to the study.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.simulation import check_closed
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.axes import Axis, Range, Values, read_axis
from soft_gripper.files.document import load_config, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.quantity import Violation, is_name, quantity
from soft_gripper.scenario.scenario_file import changed_scenario

LEAST, MOST = TOWARDS = ("least", "most")
MEAN, WORST = ("mean", "worst")
_FILE_KEYS = (".file", ".calibration", ".bench")  # ends of keys whose value is a file
_RANGE_PATTERN = re.compile(r"\s*+[-+0-9.eE]{1,400}\s*+\.\.\s*+[-+0-9.eE]{1,400}\s*+%?\s*+")
_RANGE_EXPECTED = "write a range, the lower limit first, such as 0.5..0.9 or -20..20 %"
_SCENARIO_OBJECT = "as_in_the_scenario"
_MAX_OBJECTS = 1000


@dataclass
class EndConfig:
    """A measure to minimize or maximize; earlier ones in the list take precedence."""

    # A column of a sweep, one of design/measures.py, or your own "module:function"
    measure: str = quantity("", filled=True)
    towards: str = quantity(LEAST, known=TOWARDS)
    of: str = quantity(MEAN, known=(MEAN, WORST))  # over all objects and draws


@dataclass
class LimitConfig:
    """Limits of a measure in every run; None: no limit."""

    least: float | None = None
    most: float | None = None

    def violations(self) -> Iterator[Violation]:
        if self.least is None and self.most is None:
            yield "least", None, "give least, most or both"
        if self.least is not None and self.most is not None and self.least > self.most:
            yield "least", self.least, f"must be at most {self.most:g}"


@dataclass
class DesignConfig:
    """Fields of a design study's file."""

    scenario: str = quantity("", filled=True)  # name of a shipped one, or a file
    description: str = ""
    set: dict[str, Any] = field(default_factory=dict)  # changes of every run
    # What is searched: "0.1..0.2", "1..4" (whole numbers), "-20..20 %", or a list of choices.
    vary: dict[str, Any] = quantity({}, filled=True)
    # What every design must hold: changes of the scenario, by names of your choice. A range is drawn at random.
    # At most 1000 with `unseen`.
    objects: dict[str, dict[str, Any]] = field(default_factory=lambda: {_SCENARIO_OBJECT: {}})
    unseen: dict[str, dict[str, Any]] = field(default_factory=dict)  # objects for the test alone
    draw: dict[str, Any] = field(default_factory=dict)  # ranges, drawn at random for each run; an object comes on top
    draws: int = quantity(4, least=1, most=1000)  # runs of a design with each object, the same for every design
    test_draws: int = quantity(100, least=1, most=10_000)  # of the best design with each object at the end; new ones
    wall: float | None = quantity(None, "m", above=0)  # least thickness that can be moulded
    limits: dict[str, LimitConfig] = field(default_factory=dict)  # of measures
    ends: list[EndConfig] = quantity([], filled=True)
    designs: int = quantity(60, least=1, most=10_000)  # to try
    batch: int = quantity(6, least=1, most=1000)  # designs that are tried at once, before the search learns from them
    seed: int = quantity(1, least=0)  # of the search, and of all draws

    def violations(self) -> Iterator[Violation]:
        names = [end.measure for end in self.ends]
        for i, name in enumerate(names):
            if names.count(name) > 1:
                yield f"ends[{i}].measure", name, "appears more than once"
        for part in ("objects", "unseen"):
            for name in getattr(self, part):
                if not is_name(name):
                    yield part, name, "give names of letters, digits, _ and -, beginning with a letter"
        for name in self.objects.keys() & self.unseen:
            yield f"unseen.{name}", name, "is an object of the search already"
        count = len(self.objects) + len(self.unseen)
        if count > _MAX_OBJECTS:
            yield "objects", f"{count} with unseen", f"give at most {_MAX_OBJECTS}: every design runs with each"


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """A design study after its parts have been read."""

    file: Path
    config: DesignConfig
    scenario: str
    fixed: Mapping[str, Any]  # changes of every run
    axes: Sequence[Axis]  # what is searched
    objects: Mapping[str, Mapping[str, Any]]  # changes of each object of the search; a Range is drawn at random
    unseen: Mapping[str, Mapping[str, Any]]


def load_design_study(file: Path) -> DesignStudy:
    """Reads a design study.

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    config = load_config(file, read_yaml(file), DesignConfig)
    draw = _with_ranges(file, "draw", config.draw, config.vary)
    for key, value in draw.items():
        require(isinstance(value, Range), file, f"draw.{key}", value, _RANGE_EXPECTED)
    objects, unseen = (
        {name: draw | _with_ranges(file, f"{part}.{name}", changes, config.vary) for name, changes in parts.items()}
        for part, parts in (("objects", config.objects), ("unseen", config.unseen))
    )
    axes = [_axis(file, "vary", key, value) for key, value in _with_paths(file, config.vary).items()]
    is_file = config.scenario.endswith((".yaml", ".yml"))
    scenario = str((file.parent / config.scenario).resolve()) if is_file else config.scenario
    study = DesignStudy(file, config, scenario, _with_paths(file, config.set), axes, objects, unseen)
    _check_keys(study)
    return study


def _with_ranges(file: Path, place: str, changes: Mapping[str, Any], search_keys: Mapping[str, Any]) -> dict[str, Any]:
    """Changes with absolute paths and with a Range in place of its text; no key may be searched already."""
    absolute_changes = _with_paths(file, changes)
    for key, value in absolute_changes.items():
        require(key not in search_keys, file, f"{place}.{key}", value, "leave it out: it is searched (vary)")
        if isinstance(value, str) and _RANGE_PATTERN.fullmatch(value):
            absolute_changes[key] = _axis(file, place, key, value)
    return absolute_changes


def _axis(file: Path, place: str, key: str, value: Any) -> Axis:
    """Variable from a range or a list."""
    try:
        axis = Values(key, tuple(value)) if isinstance(value, list) and value else read_axis(f"{key}={value}")
    except InputError:
        raise InputError(file, f"{place}.{key}", value, _RANGE_EXPECTED) from None
    is_choice = not isinstance(axis, Values) or len(set(map(str, axis.values))) > 1
    require(is_choice, file, f"{place}.{key}", value, f"{_RANGE_EXPECTED}, or a list of two choices or more")
    return axis


def _with_paths(file: Path, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Copy of changes with absolute paths of files."""

    def absolute(value: Any) -> Any:
        if isinstance(value, list):
            return [*map(absolute, value)]
        return value if not isinstance(value, str) or "://" in value else str((file.parent / value).resolve())

    return {key: absolute(value) if f".{key}".endswith(_FILE_KEYS) else value for key, value in changes.items()}


def fix_ranges(changes: Mapping[str, Any], shares: Iterable[float]) -> dict[str, Any]:
    """Copy of changes with each Range replaced by its value at the next share, 0 to 1; these come last."""
    fixed_values = {key: value for key, value in changes.items() if not isinstance(value, Range)}
    ranges = (value for value in changes.values() if isinstance(value, Range))
    return fixed_values | {axis.key: axis.at(fraction) for axis, fraction in zip(ranges, shares, strict=False)}


def _check_keys(study: DesignStudy) -> None:
    """Checks that the scenario takes the first and the last value of every key, and can be built with every object."""
    items = {f"objects.{name}": item for name, item in study.objects.items()}
    items |= {f"unseen.{name}": item for name, item in study.unseen.items()}
    changes: list[tuple[str, dict[str, Any]]] = [("scenario, set", {})]
    for end in (0.0, 1.0):
        changes += [("vary", {axis.key: axis.at(end)}) for axis in study.axes]
        changes += [(place, fix_ranges(item, repeat(end))) for place, item in items.items()]
    for place, key_changes in changes:
        try:
            scenario = changed_scenario(study.scenario, {**study.fixed, **key_changes})
            if place in items:
                check_closed(make_station(scenario))
        except InputError as error:
            raise error.inside(f"{study.file}: {place}") from error.__cause__
