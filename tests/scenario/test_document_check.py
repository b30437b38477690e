"""Plain data compared with a schema: what fits passes, what does not is named with its place and what would do."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from pydrake.common.schema import Transform
from pydrake.multibody.plant import MultibodyPlantConfig

from soft_gripper.errors import InputError
from soft_gripper.files.document import check_document


@dataclass
class Part:
    size: float = 1.0
    count: int | None = None


@dataclass
class Whole:
    name: str = ""
    flag: bool = False
    part: Part = field(default_factory=Part)
    other: Part | None = None
    rows: list[list[float]] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    named: dict[str, list[float]] = field(default_factory=dict)
    place: Transform = field(default_factory=Transform)
    plant: MultibodyPlantConfig = field(default_factory=MultibodyPlantConfig)


FINE = [
    {},
    {"name": "x", "flag": True, "part": {"size": 2, "count": 3}},
    {"part": {"size": 0, "count": None}, "other": None},
    {"part": {"size": "1e3"}},  # YAML takes a number without a point for text
    {"other": {"count": 4.0}},
    {"rows": [[1, 2.5], []], "parts": [{}, {"size": -1e15}]},
    {"named": {"any": [1.0], "name": []}},
    {"place": {"translation": [0, 1, 2], "rotation": {"_tag": "!Rpy", "deg": [0, 0, 90]}}},
    {"plant": {"time_step": 0.01, "contact_model": "point"}},
]
WRONG = [
    ([], "part", ""),
    ({"nam": "x"}, "nam", "did you mean 'name'?"),
    ({"zzz": 1}, "zzz", "known: name, flag, part"),
    ({3: 1}, "3", "no such key"),
    ({"name": None}, "name", ""),
    ({"flag": 1}, "flag", ""),
    ({"part": None}, "part", ""),
    ({"part": {"size": True}}, "part.size", ""),
    ({"part": {"size": "wide"}}, "part.size", ""),
    ({"part": {"size": None}}, "part.size", ""),
    ({"part": {"count": 2.5}}, "part.count", ""),
    ({"part": {"count": math.inf}}, "part.count", ""),
    ({"other": {"siz": 1}}, "other.siz", "did you mean 'size'?"),
    ({"rows": [1.0]}, "rows[0]", ""),
    ({"rows": [[1.0], [2.0, "x"]]}, "rows[1][1]", ""),
    ({"parts": [{}, {"size": []}]}, "parts[1].size", ""),
    ({"named": [1.0]}, "named", ""),
    ({"named": {"any": ["x"]}}, "named.any[0]", ""),
    ({"place": {"translation": [0, 1]}}, "place.translation", ""),
    ({"place": {"rotation": {"_tag": "!Rpy", "deg": [0, math.nan, 0]}}}, "place.rotation.deg[1]", ""),
    ({"place": {"rotation": {"deg": [0, 0, 0]}}}, "place.rotation", ""),
    ({"place": {"rotation": {"_tag": "!Uniform"}}}, "place.rotation", ""),
    ({"place": {"rotation": {"_tag": "!AngleAxis", "angle_deg": 3, "axis": [0, 0, 0]}}}, "place.rotation", ""),
    ({"place": {"base_frame": "world"}}, "place.base_frame", ""),
    ({"place": {"translation": [0, 0, math.inf]}}, "place.translation[2]", ""),
    ({"named": {"_tag": "!Rpy"}}, "named", ""),
    ({"part": {"size": math.inf}}, "part.size", ""),
    ({"part": {"size": "nan"}}, "part.size", ""),
    ({"part": {"size": 5e-324}}, "part.size", ""),
    ({"part": {"size": 1e16}}, "part.size", ""),
    ({"part": {"count": 2**32}}, "part.count", ""),
    ({"part": {"count": 10**400}}, "part.count", ""),
    ({"place": {"rotation": 90}}, "place.rotation", ""),
    ({"plant": {"timestep": 0.01}}, "plant.timestep", "did you mean 'time_step'?"),
    ({"plant": {"time_step": "slow"}}, "plant.time_step", ""),
]


@pytest.mark.parametrize("document", FINE, ids=str)
def test_what_fits(document):
    check_document(Path("a.yaml"), document, Whole)


@pytest.mark.parametrize(("document", "place", "hint"), WRONG, ids=str)
def test_what_does_not_fit(document, place, hint):
    with pytest.raises(InputError) as caught:
        check_document(Path("a.yaml"), document, Whole, "" if isinstance(document, dict) else "part")
    assert caught.value.where == Path("a.yaml")
    assert caught.value.field == place
    assert hint in caught.value.expected
