import numpy as np
import pytest

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.play.control_panel import NO_KEYS, SliderCommand, pressure_slider, slider_commands
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import PressureConfig


@pytest.fixture(scope="module")
def box() -> Station:
    return make_station(open_scenario(load_scenario("box_grasp")))


@pytest.fixture(scope="module")
def arm() -> Station:
    return make_station(open_scenario(load_scenario("arm_motion")))


def at_start(command: SliderCommand):
    return command.value([slider.value for slider in command.sliders])


def test_every_open_input_has_a_command(box: Station, arm: Station) -> None:
    for station in (box, arm):
        assert {command.port for command in slider_commands(station.parts)} == set(station.parts.inputs)


def test_a_pressure_for_every_finger(box: Station) -> None:
    left, right = slider_commands(box.parts)
    assert (left.port, right.port) == ("left_finger.pressure_command", "right_finger.pressure_command")
    assert left.value([60.0]) == [60e3]
    supply = box.scenario.pressure
    assert [1e3 * left.sliders[0].low, 1e3 * left.sliders[0].high] == [supply.minimum, supply.maximum]


@pytest.mark.parametrize(("low", "high", "begin"), [(-40e3, 150e3, 0.0), (10e3, 20e3, 10.0), (-50e3, -5e3, -5.0)])
def test_pressure_begins_as_near_to_none_as_the_supply_comes(low: float, high: float, begin: float) -> None:
    assert pressure_slider("a", PressureConfig(minimum=low, maximum=high), NO_KEYS).value == begin


def test_the_opening_begins_at_that_of_straight_fingers(arm: Station) -> None:
    command = slider_commands(arm.parts)[0]
    bases = [finger.X_WB.translation() for finger in arm.fingers]
    np.testing.assert_allclose(at_start(command), np.linalg.norm(bases[0] - bases[1]), rtol=1e-9)


def test_the_tool_goes_as_far_either_way_as_a_share_of_the_reach(arm: Station) -> None:
    plant, context = arm.plant, arm.plant.CreateDefaultContext()
    foot, hand = (
        plant.EvalBodyPoseInWorld(context, plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(name))[0]))
        for name in (arm.scenario.arm.model, "gripper")
    )
    reach = 600 * np.linalg.norm(foot.translation() - hand.translation())  # mm
    *places, _ = slider_commands(arm.parts)[1].sliders
    for slider in places:
        np.testing.assert_allclose([slider.value - slider.low, slider.high - slider.value], reach, atol=2.6)


def test_the_tool_begins_where_the_arm_holds_it(arm: Station) -> None:
    plant, context = arm.plant, arm.plant.CreateDefaultContext()
    gripper = plant.GetModelInstanceByName("gripper")
    X_WTool = plant.EvalBodyPoseInWorld(context, plant.get_body(plant.GetBodyIndices(gripper)[0]))
    assert at_start(slider_commands(arm.parts)[1]).IsNearlyEqualTo(X_WTool, 1e-9)


def test_no_key_does_two_things(box: Station, arm: Station) -> None:
    for station in (box, arm):
        keys = [key for command in slider_commands(station.parts) for slider in command.sliders for key in slider.keys]
        assert len(keys) == len(set(keys))
