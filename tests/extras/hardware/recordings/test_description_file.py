"""Descriptions of recordings: shipped ones load, wrong ones are refused with place and remedy."""

import pytest
from refusals import refused

from soft_gripper.extras.hardware.recording_schema import description_names, load_description


@pytest.mark.parametrize("name", description_names())
def test_shipped_descriptions_load(name):
    config = load_description(name)
    assert config.source.license == "MIT"
    assert config.description


@pytest.mark.parametrize(
    ("line", "field", "value"),
    [
        ("pressures: {columns: [p], sections: [1, 2]}", "pressures.sections", [1, 2]),
        ("pressures: {columns: [p], unit: V}", "pressures.scale", None),
        ("pressures: {columns: [p], unit: psi, scale: 2}", "pressures.scale", 2),
        ("markers: {columns: '{marker}'}", "markers.columns", "{marker}"),
        ("commanded_pressure: [{pattern: '(\\d+'}]", "commanded_pressure[0].pattern", "(\\d+"),
        ("load: {pattern: '\\d+'}", "load.pattern", "\\d+"),
        ("load: {pattern: 'load_?(\\d+)'}", "load.pattern", "load_?(\\d+)"),
        ("load: {pattern: '(a+)+{number}'}", "load.pattern", "(a+)+{number}"),
        ("load: {pattern: '{mass}'}", "load.pattern", "{mass}"),
        ("labels: {column: a, family: '(.*)'}", "labels.family", "(.*)"),
        ("labels: {column: a, family: '{letter}'}", "labels.family", "{letter}"),
        ("markers: {columns: '{marker:3000000000}{axis}'}", "markers.columns", "{marker:3000000000}{axis}"),
        ("markers: {columns: '{marker}{axis}{axis.__class__}'}", "markers.columns", "{marker}{axis}{axis.__class__}"),
        ("header: [a, b, a]", "header", ["a"]),
        ("frame: {z: [0, 0, 1], x: [0, 0, -2]}", "frame.x", [0, 0, -2]),
        ("frame: {x: [0, 0, 0]}", "frame.x", [0, 0, 0]),
    ],
)
def test_a_wrong_line_is_refused(describe, line, field, value):
    with refused(field, value) as caught:
        describe(text=line)
    assert str(caught.value.where).endswith("described.yaml")


def test_an_unknown_name_lists_the_known():
    with refused("--as", "clamped_beem"):
        load_description("clamped_beem")
