"""Sensors along paths: what they read and what they see."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from soft_gripper.commands.run import observability_lines
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import DeadSensorConfig, SensorConfig, SensorPathConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.link_sensors import CurvatureSensors, OrientationSensors
from soft_gripper.sensors.measurement import UNKNOWN
from soft_gripper.sensors.observability import observability
from soft_gripper.sensors.path_sensors import PathSensors, SensorPath
from soft_gripper.sensors.sensor_block import StrainSensor
from soft_gripper.sensors.sensor_layout import SensorLayout

WAYS = ("bending", "sideways", "twist")


@pytest.fixture
def spatial(shipped_finger):
    return replace(shipped_finger, yields=WAYS)


def sensors(finger, *paths, sections=2, **fields):
    return PathSensors(finger, sections, paths=paths, **fields)


def positions(layout, **strains):
    """Joint positions of equal strains along the finger, by way."""
    finger = layout.finger
    return np.repeat([strains.get(way, 0.0) for way in layout.deformations], finger.segments) * finger.segment_length


def test_a_band_reads_how_much_a_strand_of_a_rod_is_stretched(spatial):
    """Ends of a strand of 0.1 mm on a rod of constant strains, whose sections are where the matrix exponential says."""
    uniform = replace(spatial, tip=spatial.base, yields=tuple(YIELDS))
    at, slope, strains = (-7e-3, 4e-3), 0.8, {"bending": 9.0, "sideways": 4.0, "twist": 3.0, "stretch": 0.02}
    layout = sensors(uniform, SensorPath("band", (at[0],), (at[1],), y_slope=slope))
    x = at[0] - float(uniform.base.neutral_axis)

    def place(s, y):
        turn = np.array([strains["sideways"], strains["bending"], strains["twist"]])
        rate = np.zeros((4, 4))
        rate[:3, :3], rate[2, 3] = np.cross(turn, np.eye(3)).T, 1 + strains["stretch"]
        return (expm(s * rate) @ [x, y, 0, 1])[:3]

    half = 5e-5
    ends = [place(0.05 + side * half, at[1] + side * half * slope) for side in (-1, 1)]
    expected = np.linalg.norm(ends[1] - ends[0]) / (2 * half * np.hypot(1, slope))
    found = layout.ratios(positions(layout, **strains))
    np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_a_straight_path_sees_twist_to_second_order_and_a_slanted_one_to_first(spatial):
    layout = sensor_layout(spatial, SensorConfig(layout="four_faces_and_diagonal", sections=1))
    inner, outer, left, right, rising = layout.predict(positions(layout, twist=np.radians(10) / 0.12))
    assert max(inner, left, right) < outer < 5e-4
    assert rising == pytest.approx(-0.0127, rel=0.05)  # 17.7 mm off the axis


def test_a_finger_that_stays_in_its_plane_is_read_as_by_its_two_sides(shipped_finger, bent):
    """Both measure the same bends; the chord of a segment differs from its arc to second order."""
    sides = SensorLayout(shipped_finger, 2)
    layout = sensors(shipped_finger, *(SensorPath(name, (x,), (0.0,)) for name, x in (("a", 8.5e-3), ("b", -8.5e-3))))
    assert layout.deformations == ("bending",)
    q = 0.1 * bent(4, 12)
    np.testing.assert_allclose(layout.read(q), sides.read(q), atol=5e-4)


def test_values_are_exact_where_a_section_bends_equally(shipped_finger):
    """Slanted strands are not linear in the bend, but what is taken from their readings is."""
    finger = replace(shipped_finger, tip=shipped_finger.base)
    layout = sensors(finger, SensorPath("band", (-8e-3,), (0.0,), y_slope=1.0))
    q = positions(layout, bending=15.0)
    found = layout.linear(layout.read(q), 1e-3)
    np.testing.assert_allclose(found.values, layout.matrix @ q, rtol=1e-12)
    np.testing.assert_allclose(found.variance, (2 * 1e-3) ** 2)
    lost = layout.linear(np.array([np.nan, 0.0]), 1e-3)
    assert (lost.values[0], lost.variance[0]) == (0, UNKNOWN)


def test_a_scenario_lists_paths(spatial):
    config = SensorConfig(sections=2, paths=[SensorPathConfig("edge", [-8e-3], [5e-3, -5e-3], [0.1, 0.9], y_slope=0.5)])
    layout = sensor_layout(spatial, config)
    assert layout.paths == (SensorPath("edge", (-8e-3,), (5e-3, -5e-3), (0.1, 0.9), y_slope=0.5),)
    assert layout.axes == {"path": ("edge",), "section": range(2)}


@pytest.mark.parametrize(
    ("path", "field"),
    [
        (SensorPath("p", (0.011,), (0.0,)), "paths.p.x"),
        (SensorPath("p", (0.0,), (0.0, -0.011)), "paths.p.y"),
        (SensorPath("p", (0.0,), (0.0,), (0.0, 0.4)), "paths.p.at"),
    ],
)
def test_paths_that_cannot_be_read_are_refused(spatial, path, field):
    with pytest.raises(InputError) as error:
        sensors(spatial, path)
    assert error.value.field == field


def test_names_are_different(spatial):
    path = SensorPath("p", (0.0,), (0.0,))
    for paths in ((), (path, path)):
        with pytest.raises(InputError) as error:
            sensors(spatial, *paths)
        assert error.value.field == "paths"


def test_a_dead_sensor_is_named_by_its_path():
    errors = StrainErrorsConfig(dead=[DeadSensorConfig("rising", 1)])
    assert strain_errors(SensorConfig(layout="four_faces_and_diagonal", sections=2, errors=errors)).dead == (9,)


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


@pytest.mark.parametrize("kind", [CurvatureSensors, OrientationSensors])
def test_sensors_of_something_else_are_refused(shipped_finger, kind):
    layout = kind(shipped_finger, 2)
    with pytest.raises(InputError, match=f"StrainSensor: layout = '{layout.quantity}': give sensors of strain"):
        StrainSensor(layout, 0.01)
