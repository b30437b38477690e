"""make_learning_station: where its joints and its object begin."""

import pytest

from soft_gripper.extras.learning.config import load_environment
from soft_gripper.extras.learning.station import home, make_learning_station


def test_joints_begin_where_the_scenario_has_them():
    environment = load_environment("soft_pick_place", {"scenario.arm.home": [-0.1, 0.03]})
    station = make_learning_station(environment.config, environment.scenario)
    assert home(station.parts) == {"x": -0.1, "z": 0.03}
    plant = station.parts.plant
    context = plant.CreateDefaultContext()
    assert plant.GetJointByName("z").get_translation(context) == pytest.approx(0.03)


def test_an_object_stands_on_its_lowest_point(grasp_station):
    """Its frame begins at 30.01 mm, which leaves 10 um to the table."""
    assert grasp_station.object_height == pytest.approx(0.03, abs=1e-6)
