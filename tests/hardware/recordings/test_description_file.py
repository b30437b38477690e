"""Descriptions of recordings: shipped ones load, wrong ones are refused with place and remedy."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.hardware.recording_schema import description_names, load_description


@pytest.mark.parametrize("name", description_names())
def test_shipped_descriptions_load(name):
    config = load_description(name)
    assert config.source.license == "MIT"
    assert config.description


def test_there_are_three():
    assert description_names() == ["clamped_beam", "pneumatic_segment", "two_segment_arm"]


@pytest.mark.parametrize(
    ("line", "field", "value"),
    [
        ("tyme_unit: s", "tyme_unit", "s"),
        ("time_unit: min", "time_unit", "min"),
        ("gravity: [0, 0]", "gravity", [0, 0]),
        ("reference: 0", "reference", 0),
        ("length: .inf", "length", float("inf")),
        ("event: bang", "event", "bang"),
        ("pressures: {columns: [p], unit: atm}", "pressures.unit", "atm"),
        ("pressures: {columns: [p], sections: [1, 2]}", "pressures.sections", [1, 2]),
        ("pressures: {columns: [p], sections: [0]}", "pressures.sections[0]", 0),
        ("pressures: {columns: [p], unit: V}", "pressures.scale", None),
        ("pressures: {columns: [p], unit: psi, scale: 2}", "pressures.scale", 2),
        ("lengths: {wires: {a: {column: l, side: left}}, spacing: 0.04}", "lengths.wires.a.side", "left"),
        ("lengths: {wires: {a: {column: l, section: 0}}, spacing: 0.04}", "lengths.wires.a.section", 0),
        ("lengths: {wires: {a: {column: l}}}", "lengths.spacing", 0),
        ("markers: {columns: '{marker}'}", "markers.columns", "{marker}"),
        ("commanded_pressure: [{pattern: '(\\d+'}]", "commanded_pressure[0].pattern", "(\\d+"),
        ("load: {pattern: '\\d+'}", "load.pattern", "\\d+"),
        ("load: {pattern: '(\\d+)', masses: {'101': -1}}", "load.masses.101", -1),
        ("poses: {tip: {position: [a, b]}}", "poses.tip.position", ["a", "b"]),
        ("poses: {tip: {position: [a, b, c]}}", "poses.tip.quaternion", []),
        ("header: [a, b, a]", "header", ["a"]),
        ("load_place: [1]", "load_place", [1]),
        ("frame: {z: [0, 0, 1], x: [0, 0, -2]}", "frame.x", [0, 0, -2]),
        ("frame: {x: [0, 0, 0]}", "frame.x", [0, 0, 0]),
    ],
)
def test_a_wrong_line_is_refused(describe, line, field, value):
    with pytest.raises(InputError, match=r"described\.yaml") as caught:
        describe(text=line)
    assert (caught.value.field, caught.value.value) == (field, value)


def test_a_key_that_appears_twice_is_refused(describe):
    with pytest.raises(InputError, match="more than once"):
        describe("length: 1")


def test_an_unknown_name_lists_the_known():
    with pytest.raises(InputError, match="clamped_beam"):
        load_description("clamped_beem")


def test_a_missing_file_is_named():
    with pytest.raises(InputError, match="No such file"):
        load_description("nowhere.yaml")
