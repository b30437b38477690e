"""Which ways of a finger sensors fix, and how well: a table of layouts, and least squares."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.commands.run import observability_lines
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.observability import observability

DEGREES = np.pi / 180


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("sides", (0.19, None, None)),
        ("outer_pair", (0.13, 0.29, None)),
        ("four_faces", (0.15, 0.29, None)),
        ("four_faces_and_diagonal", (0.15, 0.27, 0.42)),
        ("outer_pair_and_diagonals", (0.12, 0.27, 0.27)),
    ],
)
def test_layouts_fix_bends_and_some_fix_twist(shipped_finger, name, expected):
    """Strain noise of 0.1 % and sections of 60 mm; degrees."""
    spatial = replace(shipped_finger, yields=("bending", "sideways", "twist"))
    found = observability(sensor_layout(spatial, SensorConfig(layout=name, sections=2)), 1e-3)
    assert [each.deformation for each in found] == ["bending", "sideways", "twist"]
    assert [each.is_seen for each in found] == [std is not None for std in expected]
    for each, std in zip(found, expected, strict=True):
        if std is not None:
            np.testing.assert_allclose(each.std / DEGREES, std, rtol=0.05)


def test_standard_deviations_are_those_of_what_least_squares_finds(shipped_finger):
    """Of many draws of noise, by the pseudoinverse, without a prior."""
    spatial = replace(shipped_finger, yields=("bending", "sideways", "twist"))
    layout = sensor_layout(spatial, SensorConfig(layout="four_faces_and_diagonal", sections=1))
    noise = 1e-4 * np.random.default_rng(1).standard_normal((4000, layout.readings))
    equally = np.kron(np.eye(3), np.ones((12, 1)) / 12)
    fitted = noise @ np.linalg.pinv(layout.slopes(layout.straight) @ equally).T
    found = observability(layout, 1e-4)
    np.testing.assert_allclose(fitted.std(axis=0), [each.std[0] for each in found], rtol=0.05)


def test_a_run_says_what_is_seen_of_fingers_in_space_and_nothing_of_others():
    in_space = [f"models.{side}_finger.fingers.all.yields=bending sideways twist" for side in ("left", "right")]
    assert observability_lines(make_station(load_scenario("free_bending", []))) == []
    (line,) = observability_lines(make_station(load_scenario("free_bending", in_space)))
    assert line.startswith(
        "note: what the sensors of left_finger, right_finger observe of each section: bending to 0.0"
    )
    assert line.endswith(" degrees, sideways not at all, twist not at all")
    faces = ["sensor.layout=four_faces_and_diagonal", "sensor.errors.preset=realistic", "estimator.type=gaussian"]
    (line,) = observability_lines(make_station(load_scenario("free_bending", [*in_space, *faces])))
    assert "not at all" not in line


def test_two_readings_on_one_face_do_not_tell_a_bend_from_a_stretch(shipped_finger):
    stretching = replace(shipped_finger, yields=("bending", "sideways", "twist", "stretch"))
    pair, faces = (
        {each.deformation: each for each in observability(sensor_layout(stretching, SensorConfig(layout=name)), 1e-4)}
        for name in ("outer_pair", "four_faces_and_diagonal")
    )
    assert not pair["bending"].is_seen
    assert not pair["stretch"].is_seen
    assert all(each.is_seen for each in faces.values())
    assert str(pair["twist"]) == "twist not at all"
    assert str(faces["stretch"]).startswith("stretch to 0.0")
