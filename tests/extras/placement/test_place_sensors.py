"""Designs of a small search: of every number the best, as rows, as a figure, and as part of a scenario."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from refusals import refused

from soft_gripper.extras.placement.catalogue import CURVATURE, KINDS, PATHS, STRAIN, Design, divisions, leaves_its_plane
from soft_gripper.extras.placement.commands.place_sensors import check_runs
from soft_gripper.extras.placement.errors import Assumptions, Errors
from soft_gripper.extras.placement.place_sensors import best_designs, place_sensors
from soft_gripper.extras.placement.placed_report import MEAN, design_rows, made_rows, placement_figure, scenario_part
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, uncertainty

ASSUMED = Assumptions("realistic", 10.0)


@pytest.fixture(scope="module")
def planar(in_plane):
    return place_sensors(2, [in_plane], ASSUMED)


def test_in_the_plane_all_borders_are_tried(planar):
    assert {design.borders for design in planar.tried if design.borders} == {(round(i / 12, 4),) for i in range(1, 12)}
    assert [one.design.sensors for one in planar.best] == [1, 2]
    assert planar.kinds == [STRAIN]
    one, two = planar.best
    assert two.predicted.score == min(errors.score for errors in planar.tried.values()) < one.predicted.score
    assert [equal.design.borders for equal in planar.equal] == [(0.5,)]


def test_rows_are_those_of_the_search(planar):
    rows, made = design_rows(planar), made_rows(planar)
    assert len(rows) == len(planar.tried) == 12
    assert [row.sensors for row in rows] == sorted(row.sensors for row in rows)
    assert [(row.sections, row.sensors, row.run) for row in made] == [
        (sections, count, run)
        for sections, count in (("best", 1), ("best", 2), ("equal", 2))
        for run in ("contacts", MEAN)
    ]
    assert made[2].pose_mm == made[3].pose_mm == pytest.approx(1e3 * planar.best[1].made["contacts"].pose)


def test_the_figure_has_a_panel_for_every_quantity(planar):
    figure = placement_figure(planar)
    assert len(figure.axes) == 3, "there is no twist in the plane"
    assert all(axes.get_yscale() == "log" for axes in figure.axes)


@pytest.fixture(scope="module")
def spatial(in_space):
    return place_sensors(2, [in_space], ASSUMED)


@pytest.mark.slow
def test_in_space_all_kinds_and_pairs_of_paths_are_tried(spatial):
    along = [design.paths for design in spatial.tried if design.kind == STRAIN and not design.borders]
    assert len(along) == len(set(along)) == 20 + 190
    assert len(PATHS) == 20
    assert {design.kind for design in spatial.tried} == {*KINDS}
    for one in spatial.best:
        rivals = [each for each in spatial.tried if each.kind == one.design.kind and each.sensors <= one.design.sensors]
        assert one.predicted.score == min(spatial.tried[each].score for each in rivals)


def assert_taken(placed, kind, shipped):
    """A scenario takes what is written: the same sensors, with the same errors and the same assumptions."""
    part = yaml.safe_load(scenario_part(placed, kind, SensorConfig(), ASSUMED))
    overrides = [f"{name}.{field}={json.dumps(value)}" for name, of in part.items() for field, value in of.items()]
    scenario = load_scenario(shipped, overrides)
    config = placed.best_of(kind).config(placed.finger, SensorConfig())
    expected, layout = (sensor_layout(placed.finger, each) for each in (config, scenario.sensor))
    np.testing.assert_array_equal(layout.jacobian, expected.jacobian)
    given = uncertainty(scenario.estimator, scenario.sensor)
    for name in ("reading", "gain", "offset", "drift", "bend_per_pressure"):
        assert getattr(given, name) == pytest.approx(getattr(ASSUMED.uncertainty(kind), name), rel=1e-2)
    assert scenario.sensor.errors == ASSUMED.errors(kind)
    assert scenario.estimator.type == "contact"


def test_a_scenario_takes_what_is_written(planar):
    assert_taken(planar, STRAIN, "free_bending")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_scenario_in_space_takes_what_is_written(spatial, kind):
    assert_taken(spatial, kind, "turned_box_grasp")


def test_a_design_with_more_sensors_has_to_be_better():
    errors = {Design(CURVATURE, ()): 1.0, Design(CURVATURE, (0.5,)): 1.0, Design(STRAIN, (), ("outer",)): 3.0,
              Design(STRAIN, (0.5,), ("outer",)): 2.0, Design(STRAIN, (0.3333,), ("outer",)): 2.5}  # fmt: skip
    best = best_designs({design: Errors(*[size] * 4) for design, size in errors.items()})
    assert best == [Design(CURVATURE, ()), Design(STRAIN, (), ("outer",)), Design(STRAIN, (0.5,), ("outer",))]


def test_sections_are_equal_or_shorter_toward_the_base(shipped_finger):
    assert divisions(shipped_finger, 3) == [(), (6,), (4,), (4, 8), (2, 7)]
    assert not leaves_its_plane(shipped_finger)


def run(name, *fingers):
    """What is looked at of a run."""
    return SimpleNamespace(scenario=load_scenario(name), fingers=[SimpleNamespace(finger=f) for f in fingers])


@pytest.mark.parametrize(
    ("name", "field"), [("pick_and_place_box", "task"), ("tip_distance_steps", "control.set_points")]
)
def test_runs_without_steps_of_pressure_are_refused(shipped_finger, name, field):
    with refused(field, "given"):
        check_runs(2, {name: run(name, shipped_finger)})


def test_all_fingers_are_alike(shipped_finger):
    one = run("free_bending", shipped_finger)
    check_runs(2, {"one": one})
    for field, value in (("segments", 10), ("yields", ("bending", "sideways", "twist"))):
        with refused(field):
            check_runs(2, {"one": one, "two": run("free_bending", replace(shipped_finger, **{field: value}))})


def test_a_finger_has_no_more_sections_than_segments(shipped_finger):
    with refused("count", 13):
        check_runs(13, {"one": run("free_bending", shipped_finger)})
