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
    ([], "part", "give a mapping"),
    ({"nam": "x"}, "nam", "did you mean 'name'?"),
    ({"zzz": 1}, "zzz", "known: name, flag, part"),
    ({3: 1}, "3", "no such key"),
    ({"name": None}, "name", "give text"),
    ({"flag": 1}, "flag", "give true or false"),
    ({"part": None}, "part", "give a mapping"),
    ({"part": {"size": True}}, "part.size", "give a number"),
    ({"part": {"size": "wide"}}, "part.size", "give a number"),
    ({"part": {"size": None}}, "part.size", "give a number"),
    ({"part": {"count": 2.5}}, "part.count", "give a whole number"),
    ({"part": {"count": math.inf}}, "part.count", "give a whole number"),
    ({"other": {"siz": 1}}, "other.siz", "did you mean 'size'?"),
    ({"rows": [1.0]}, "rows[0]", "give a list"),
    ({"rows": [[1.0], [2.0, "x"]]}, "rows[1][1]", "give a number"),
    ({"parts": [{}, {"size": []}]}, "parts[1].size", "give a number"),
    ({"named": [1.0]}, "named", "give a mapping"),
    ({"named": {"any": ["x"]}}, "named.any[0]", "give a number"),
    ({"place": {"translation": [0, 1]}}, "place.translation", "give three numbers, m"),
    ({"place": {"rotation": {"_tag": "!Rpy", "deg": [0, math.nan, 0]}}}, "place.rotation.deg[1]", "finite"),
    ({"place": {"rotation": {"deg": [0, 0, 0]}}}, "place.rotation", "write !Rpy"),
    ({"place": {"rotation": {"_tag": "!Uniform"}}}, "place.rotation", "write !Rpy"),
    ({"place": {"rotation": {"_tag": "!AngleAxis", "angle_deg": 3, "axis": [0, 0, 0]}}}, "place.rotation", "!Rpy"),
    ({"place": {"base_frame": "world"}}, "place.base_frame", "leave it out"),
    ({"place": {"translation": [0, 0, math.inf]}}, "place.translation[2]", "finite"),
    ({"named": {"_tag": "!Rpy"}}, "named", "without a tag"),
    ({"part": {"size": math.inf}}, "part.size", "give a finite number"),
    ({"part": {"size": "nan"}}, "part.size", "give a finite number"),
    ({"part": {"size": 5e-324}}, "part.size", "1e-15 to 1e+15"),
    ({"part": {"size": 1e16}}, "part.size", "1e-15 to 1e+15"),
    ({"part": {"count": 2**32}}, "part.count", "up to 4294967295"),
    ({"part": {"count": 10**400}}, "part.count", "give a whole number"),
    ({"place": {"rotation": 90}}, "place.rotation", "write !Rpy"),
    ({"plant": {"timestep": 0.01}}, "plant.timestep", "did you mean 'time_step'?"),
    ({"plant": {"time_step": "slow"}}, "plant.time_step", "give a number"),
]


@pytest.mark.parametrize("document", FINE, ids=str)
def test_what_fits(document):
    check_document(Path("a.yaml"), document, Whole)


@pytest.mark.parametrize(("document", "place", "expected"), WRONG, ids=str)
def test_what_does_not_fit(document, place, expected):
    with pytest.raises(InputError) as caught:
        check_document(Path("a.yaml"), document, Whole, "" if isinstance(document, dict) else "part")
    assert caught.value.where == Path("a.yaml")
    assert caught.value.field == place
    assert expected in caught.value.expected
