"""Objects that slide, and the friction that holds them."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.runs.scores.grasp import DROPPED, HELD, RESTING
from soft_gripper.runs.scores.recorded_grasps import recorded_grasp
from soft_gripper.runs.scores.recorded_object import RecordedObject
from soft_gripper.runs.scores.recorded_slips import recorded_slip
from soft_gripper.runs.scores.slipping import (
    WILL_HOLD,
    WILL_SLIP,
    as_predicted,
    has_settled,
    held_span,
    object_friction,
    sliding_since,
    weight_share,
)
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.truth.contact import combined_friction

TIME = 0.01 * np.arange(200)  # s


def test_a_weight_takes_its_share_of_what_coulomb_allows():
    assert weight_share(np.array([1.0, 2.0]), np.array([0.5, 0.75]), 1.0) == pytest.approx(0.5)
    assert weight_share(np.zeros(2), np.array([0.5, 0.25]), 0.5) == np.inf


def test_the_friction_of_the_object_gives_the_coefficient():
    for coefficient in (0.1, 0.9, 1.7):
        assert combined_friction(object_friction(coefficient, 0.9), 0.9) == pytest.approx(coefficient)
    assert object_friction(1.8, 0.9) == np.inf


def test_a_bounce_is_no_loss_and_a_touch_after_it_no_hold():
    force = np.zeros(200)
    force[20:50] = force[55:100] = force[150:160] = 1.0
    assert held_span(TIME, force) == (20, 100)
    assert held_span(TIME[:104], force[:104]) == (20, 104), "it may touch again"
    assert held_span(TIME, np.zeros(200)) is None


@pytest.mark.parametrize(("late", "settled"), [(1.04, True), (1.1, False), (0.9, False)])
def test_a_force_that_grows_has_not_settled(late, settled):
    assert has_settled(np.repeat([1.0, late], 25)) is settled


def test_a_slide_goes_on_where_it_sticks_for_a_moment():
    speed = np.zeros((200, 2))
    speed[30:60] = speed[120:150, 1:] = speed[165:] = 5e-3
    begin, on = sliding_since(TIME, speed)
    assert begin == pytest.approx(120, abs=3)
    assert on.tolist() == [False, True]
    assert sliding_since(TIME[:100], speed[:100]) is None


@pytest.mark.parametrize(
    ("predicted", "grasp", "right"),
    [(WILL_HOLD, HELD, True), (WILL_HOLD, DROPPED, False), (WILL_SLIP, RESTING, False), (WILL_SLIP, DROPPED, True)],
)
def test_a_prediction_is_compared_with_the_grasp(predicted, grasp, right):
    assert as_predicted(predicted, grasp) is right


def lifted(friction):
    """A station in which two fingers lift a bottle of some friction, and its recording."""
    changes = {"models.bottle.friction": friction, "estimator.type": "arcs"}
    station = make_private_station(changed_scenario("bottle_grasp", changes))
    return station, run_station(station)


@pytest.fixture(scope="module")
def slippery():
    return lifted(0.12)


def test_a_slippery_bottle_slips_as_it_is_lifted(slippery):
    station, recording = slippery
    slip = recorded_slip(RecordedObject(station, recording, "bottle"))
    lift = float(recording["time"].values[np.argmax(recording["task.phase"].values == 1)])
    assert slip.predicted == WILL_SLIP
    assert slip.slips_in == "lift"
    assert 0 <= slip.slips_s - lift < 0.2
    assert slip.slips_on == "left_finger and right_finger"
    assert slip.slips_s < slip.lost_s < recording["time"].values[-1]
    assert recorded_grasp(RecordedObject(station, recording, "bottle"))[0].grasp == DROPPED


@pytest.mark.slow  # two more lifts; the one above runs the same code
@pytest.mark.parametrize(("share", "held"), [(0.97, False), (1.03, True)])
def test_the_least_friction_of_the_object_holds_it_and_less_does_not(slippery, share, held):
    least = recorded_slip(RecordedObject(*slippery, "bottle")).least_object_friction
    station, recording = lifted(share * least)
    slip = recorded_slip(RecordedObject(station, recording, "bottle"))
    assert (recorded_grasp(RecordedObject(station, recording, "bottle"))[0].grasp == HELD) is held
    assert slip.predicted == (WILL_HOLD if held else WILL_SLIP)
    assert np.isnan(slip.slips_s) == held
