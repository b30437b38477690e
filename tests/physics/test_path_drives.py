"""What drives fingers along paths, in the plant: chambers in several directions, tendons, and their friction."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

PRESSURE = 60e3
WEIGHTLESS = "gravity=[0, 0, 0]"


def three_chambers(pressures, *overrides):
    steps = [
        f"pressure.steps.finger::{name}=[{p}]" for name, p in zip(("inner", "left", "right"), pressures, strict=True)
    ]
    short = ["pressure.settle=5.9", "pressure.hold_samples=10", WEIGHTLESS]
    return simulate(load_scenario("three_chambers", [*steps, *short, *overrides]))


@pytest.fixture(scope="module")
def finger():
    return make_station(load_scenario("three_chambers")).fingers[0].finger


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pressures", "direction"),
    [((0, 1, 1), 0.0), ((1, 1, 0), -120.0), ((0, 1, 0), -60.0), ((1, 0, 0), 180.0)],
    ids=["left and right", "inner and left", "left", "inner"],
)
def test_three_chambers_bend_in_their_direction_along_an_arc(finger, pressures, direction):
    """Away from the pressed chambers: a straight pull of p A on levers of 6 mm gives an arc that is a little longer."""
    recording = three_chambers([PRESSURE * share for share in pressures])
    x, y, z = recording["finger.true_tip_position"].values[-1]
    off = (np.degrees(np.arctan2(y, x)) - direction + 180) % 360 - 180
    assert abs(off) < 0.5
    section, force = finger.section(0.06), PRESSURE * 25e-6
    count = sum(pressures)
    length = finger.length * (1 + count * force / section.stretch_stiffness)
    angle = finger.length * force * 6e-3 / section.bending_stiffness  # of one chamber, or of two at 120 degrees
    np.testing.assert_allclose(np.hypot(x, y), length / angle * (1 - np.cos(angle)), atol=1e-4)
    np.testing.assert_allclose(z, length / angle * np.sin(angle), atol=1e-4)


@pytest.mark.slow
def test_equal_pressures_stretch_alone(finger):
    tip = three_chambers([PRESSURE] * 3)["finger.true_tip_position"].values[-1]
    stretched = finger.length * (1 + 3 * PRESSURE * 25e-6 / finger.section(0.06).stretch_stiffness)
    np.testing.assert_allclose(tip, [0, 0, stretched], atol=1e-6)


@pytest.mark.parametrize(
    ("overrides", "field", "value"),
    [
        (["tendons.steps.all=[-1]"], "tendons.steps.all[0]", -1),
        (["tendons.steps.left_finger::extensor=[1]"], "left_finger::extensor", [1]),
        (["tendons.maximum=2"], "tendons.maximum", 2),
        (["tendons.command=push"], "tendons.command", "push"),
    ],
)
def test_what_tendons_cannot_do_is_refused(overrides, field, value):
    with refused(field, value):
        make_station(load_scenario("tendon_grasp", overrides))
