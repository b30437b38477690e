"""What would narrow the band of a contact force: with it, the band is as wide as was said."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import Push, in_balance

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.runs.scores.contact_forces import band_widths, contact_rows
from soft_gripper.runs.scores.narrower_bands import narrower_bands, narrower_text
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout

ASSUMED = Uncertainty(reading=2e-3, gain=0.02)
GRAVITY, PRESSURE = np.array([0.0, 0.0, 9.81]), 80e3


def width(layout, assumed, q):
    """Width of the band over the force, of a finger in a posture."""
    shape, given = ContactShape(layout, assumed), (layout.read(q), layout.finger.pressure_torque(PRESSURE), GRAVITY)
    least, _, most = shape.posterior(*given).transverse_force_interval
    return (most - least) / shape(*given).contact.transverse_force


@pytest.mark.parametrize(("place", "force"), [(0.075, 1.2), (0.1, 0.5)])
def test_widths_are_those_of_the_finger_with_the_change(shipped_finger, place, force):
    true = in_balance(shipped_finger, PRESSURE, 9.81 + 0j, [Push(place, force)])
    two, three = SensorLayout(shipped_finger, 2), SensorLayout(shipped_finger, 3)
    driving = shipped_finger.pressure_torque(PRESSURE)
    estimated = ContactShape(two, ASSUMED)(two.read(true), driving, GRAVITY).q
    widths = narrower_bands(two, ASSUMED, 0.01, estimated, driving, GRAVITY, {"3 sections": three})
    expected = {
        "": width(two, ASSUMED, true),
        "a calibration": width(two, replace(ASSUMED, bend_per_pressure=0.01, bend_variation=EXACT, gain=0.01), true),
        "a mean over 0.2 s": width(two, replace(ASSUMED, reading=2e-3 / np.sqrt(20)), true),
        "3 sections": width(three, ASSUMED, true),
    }
    assert widths == pytest.approx(expected, rel=0.15)
    assert widths["3 sections"] < 0.8 * widths[""]


def test_a_calibration_widens_nothing(shipped_finger):
    """An exact model is known better than a calibrated one, and a contact that is overlooked has no width."""
    exact, layout = Uncertainty(bend_per_pressure=EXACT), SensorLayout(shipped_finger, 4)
    driving = shipped_finger.pressure_torque(PRESSURE)
    pressed, free = (in_balance(shipped_finger, PRESSURE, 9.81 + 0j, pushes) for pushes in ([Push(0.1, 0.5)], ()))
    widths = narrower_bands(layout, exact, 0.01, pressed, driving, GRAVITY, {})
    assert widths["a calibration"] == pytest.approx(widths[""], rel=1e-12)
    assert narrower_bands(layout, exact, 0.01, free, driving, GRAVITY, {})[""] == np.inf


@pytest.fixture(scope="module")
def grasp():
    changes = ["sensor.sections=2", "sensor.errors.preset=realistic", "pressure.settle=0.5", "pressure.hold_samples=50"]
    return make_private_station(load_scenario("box_grasp", [*changes, "pressure.steps={all: [0.0, 75.0e3]}"]))


def test_the_first_width_is_that_of_the_band_of_a_run(grasp):
    recording = simulate(grasp.scenario)
    row = contact_rows(grasp, recording)[-1]
    widths = band_widths(grasp, recording, row)
    assert widths[""] == pytest.approx((row.most_n - row.least_n) / row.transverse_n, rel=0.1)
    assert list(widths)[1:] == ["a calibration", "a mean over 0.2 s", "3 sections", "its border at a third"]
    assert not band_widths(grasp, recording, replace(row, least_n=0.0)), "no contact"


def test_changes_that_are_worth_it_are_named():
    widths = {"": 0.9, "a calibration": 0.3, "3 sections": 0.8}
    assert narrower_text("f", widths) == "f: the band is 0.90 of the force wide; with a calibration 0.30\n"
    nothing = narrower_text("f", {**widths, "a calibration": 0.85})
    assert nothing == "f: the band is 0.90 of the force wide; hardly narrower with a calibration, 3 sections\n"
    assert not narrower_text("f", {})
