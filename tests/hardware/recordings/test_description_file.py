"""Descriptions of recordings: shipped ones load, wrong ones are refused with place and remedy."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.hardware.recordings.description_file import description_names, load_description


@pytest.mark.parametrize("name", description_names())
def test_shipped_descriptions_load(name):
    config = load_description(name)
    assert config.source.license == "MIT"
    assert config.description


def test_there_are_three():
    assert description_names() == ["clamped_beam", "pneumatic_segment", "two_segment_arm"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("tyme_unit: s", "did you mean 'time_unit'"),
        ("time_unit: min", "one of s, ms"),
        ("gravity: [0, 0]", "three finite numbers"),
        ("reference: 0", "above 0"),
        ("reference: .nan", "finite number"),
        ("length: 1", "more than once"),
        ("event: bang", '"release" or "step"'),
        ("pressures: {columns: [p], unit: atm}", "one of Pa, hPa"),
        ("pressures: {columns: [p], sections: [1, 2]}", "one for each of the 1 columns"),
        ("pressures: {columns: [p], unit: V}", "or V, with a scale"),
        ("pressures: {columns: [p], unit: psi, scale: 2}", "only a sensor in V"),
        ("lengths: {wires: {a: {column: l, side: left}}, spacing: 0.04}", '"inner" or "outer"'),
        ("lengths: {wires: {a: {column: l}}}", "distance of the two sides"),
        ("commanded_pressure: [{pattern: '(\\d+'}]", "no regular expression"),
        ("load: {pattern: '\\d+'}", "one group"),
        ("load: {pattern: '(\\d+)', masses: {'101': -1}}", "above 0, kg"),
        ("poses: {tip: {position: [a, b]}}", "columns of x, y, z"),
        ("header: [a, b, a]", "a name of its own"),
        ("load_place: [1]", "x and z"),
    ],
)
def test_a_wrong_line_is_refused(describe, line, said):
    with pytest.raises(InputError, match=r"described\.yaml") as error:
        describe(line)
    assert said in str(error.value)


def test_axes_along_each_other_are_refused(describe):
    with pytest.raises(InputError, match=r"across frame\.z"):
        describe(text="frame: {z: [0, 0, 1], x: [0, 0, -2]}")


def test_an_unknown_name_lists_the_known():
    with pytest.raises(InputError, match="clamped_beam"):
        load_description("clamped_beem")


def test_a_missing_file_is_named():
    with pytest.raises(InputError, match="No such file"):
        load_description("nowhere.yaml")
