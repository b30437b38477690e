"""Designs of a small search: of every number the best, as rows, as a figure, and as part of a scenario."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml

from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.placement.catalogue import CURVATURE, KINDS, PATHS, STRAIN, Design, divisions, errors_of
from soft_gripper.extras.placement.place_in_space import SpatialAssumptions, best_designs, place_in_space
from soft_gripper.extras.placement.pushed_finger import PushedFinger
from soft_gripper.extras.placement.spatial_scores import Errors, Scores
from soft_gripper.extras.placement.spatial_tables import design_rows, pareto_figure, scenario_part, verified_rows
from soft_gripper.extras.placement.spatial_tasks import leaves_its_plane, tasks
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.sensor_presets import sensor_layout, uncertainty

ASSUMED = SpatialAssumptions("realistic", 10.0)


@pytest.fixture(scope="module")
def placed(spatial_tasks):
    return place_in_space(2, spatial_tasks, ASSUMED)


@pytest.mark.slow
def test_no_better_design_was_tried_than_those_that_are_reported(placed):
    for one in placed.best:
        rivals = [
            errors.score
            for design, errors in placed.tried.items()
            if design.kind == one.design.kind and design.sensors <= one.design.sensors
        ]
        assert one.predicted.score == min(rivals)
    assert max(design.sensors for design in placed.tried) == 2
    assert {design.kind for design in placed.tried} == {*KINDS}


@pytest.mark.slow
def test_all_pairs_of_paths_were_tried(placed):
    along = [design.paths for design in placed.tried if design.kind == STRAIN and not design.borders]
    assert len(along) == len(set(along)) == 20 + 190
    assert len(PATHS) == 20


def test_a_design_with_more_sensors_has_to_be_better():
    errors = {Design(CURVATURE, ()): 1.0, Design(CURVATURE, (0.5,)): 1.0, Design(STRAIN, (), ("outer",)): 3.0,
              Design(STRAIN, (0.5,), ("outer",)): 2.0, Design(STRAIN, (0.3333,), ("outer",)): 2.5}  # fmt: skip
    best = best_designs({design: Errors(*[size] * 4) for design, size in errors.items()})
    assert best == [Design(CURVATURE, ()), Design(STRAIN, (), ("outer",)), Design(STRAIN, (0.5,), ("outer",))]


def test_a_finger_with_three_chambers_is_scored_in_all_its_directions():
    (finger,) = expand_urdf(DIRECTORY / "grippers/three_chambers.urdf").fingers
    assert leaves_its_plane(finger)
    assert not leaves_its_plane(replace(finger, yields=("bending", "stretch")))
    pressures = np.array([[60e3, 0, 0], [0, 60e3, 0], [60e3, 60e3, 60e3]])
    all_tasks = tasks(PushedFinger(finger, np.array([0.0, 0.0, 9.81])), pressures)
    way = 12 * all_tasks.statics.ways.index("stretch")
    expected = 3 * 60e3 * 25e-6 / (2.67e5 * 3.25e-4) * 0.12  # by three chambers, on what they leave of the section
    assert all_tasks.q[2, way : way + 12].sum() == pytest.approx(expected, rel=0.05)  # and by its weight
    predicted = Scores(all_tasks, STRAIN, Uncertainty())
    faces = ("inner", "outer", "left", "right", "outer_rising")
    assert np.all(np.diff([predicted(Design(STRAIN, (0.5,), faces[:n])) for n in range(1, 6)], axis=0) <= 0)


def test_sections_are_equal_or_shorter_toward_the_base(spatial_finger):
    assert divisions(spatial_finger, 3) == [(), (0.5,), (0.3333,), (0.3333, 0.6667), (0.1667, 0.5833)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_scenario_takes_what_is_written(placed, kind):
    """The same sensors, with the same errors and the same assumptions."""
    part = yaml.safe_load(scenario_part(placed, kind, ASSUMED))
    overrides = [f"{name}.{field}={json.dumps(value)}" for name, of in part.items() for field, value in of.items()]
    scenario = load_scenario("turned_box_grasp", overrides)
    expected, layout = placed.best_of(kind).design.layout(placed.finger), sensor_layout(placed.finger, scenario.sensor)
    np.testing.assert_array_equal(layout.jacobian, expected.jacobian)
    assert (layout.quantity, layout.readings) == (expected.quantity, expected.readings)
    given = uncertainty(scenario.estimator, scenario.sensor)
    for name in ("reading", "gain", "offset", "drift", "bend_per_pressure"):
        assert getattr(given, name) == pytest.approx(getattr(ASSUMED.uncertainty(kind), name), rel=1e-2)
    assert scenario.sensor.errors == errors_of(kind, "realistic")


@pytest.mark.slow
def test_rows_are_those_of_the_search(placed):
    rows, best = design_rows(placed), verified_rows(placed)
    assert len(rows) == len(placed.tried)
    assert [row.sensors for row in rows] == sorted(row.sensors for row in rows)
    first = next(row for row in best if row.kind == STRAIN)
    assert first.tip_mm == pytest.approx(
        1e3 * next(one for one in placed.best if one.design.kind == STRAIN).predicted.tip
    )
    assert first.made_twist_deg < 90


@pytest.mark.slow
def test_the_figure_has_a_line_for_every_kind_and_quantity(placed):
    figure = pareto_figure(placed)
    assert [len(axes.lines) for axes in figure.axes] == [3 * len(KINDS)] * 4
    assert all(axes.get_yscale() == "log" for axes in figure.axes)


@pytest.mark.slow
def test_what_is_tried_further_does_not_change_what_was_found(placed, spatial_tasks):
    """The same design gets the same random numbers."""
    alone = place_in_space(1, spatial_tasks, ASSUMED)
    assert alone.tried.items() <= placed.tried.items()
    assert alone.best == placed.best[:3]
