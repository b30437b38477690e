"""Other plants: what their files say, that they can be moulded, and that they bend about as far."""

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_station
from studies.robustness.plants import FINE, PLANTS, RUBBER, TAPERED, rubber_moment


def test_files_say_what_is_different(shipped_finger) -> None:
    fine, tapered, rubber = (plant.finger() for plant in (FINE, TAPERED, RUBBER))
    assert (fine.segments, fine.base, fine.elastic_law) == (24, shipped_finger.base, None)
    assert (tapered.segments, tapered.base.thickness, tapered.tip.thickness) == (12, 0.035, 0.015)
    assert rubber.segments == 24
    assert rubber.elastic_law is not None


def test_rubber_is_as_stiff_as_believed_at_60_degrees_and_softer_beyond(shipped_finger) -> None:
    rubber = RUBBER.finger()
    nominal = [np.full(12, np.radians(bend) / 12) for bend in (60, 120, -30)]
    simulated = [np.repeat(q, 2) / 2 for q in nominal]
    linear, curved = (
        [float(finger.elastic_torque(q)[len(q) // 2]) for q in angles]
        for finger, angles in ((shipped_finger, nominal), (rubber, simulated))
    )
    assert curved[0] == pytest.approx(linear[0], rel=0.01)
    assert curved[1] < 0.95 * linear[1]
    assert curved[2] < 1.1 * linear[2] < 0


def test_rubber_that_hardly_bends_is_as_stiff_as_its_cross_section(tapered_finger) -> None:
    for section in (tapered_finger.base, tapered_finger.tip):
        more, less = rubber_moment(section, np.array([1e-3, -1e-3]))
        assert (more - less) / 2e-3 == pytest.approx(section.bending_stiffness, rel=5e-3)  # by strips


def test_a_tapered_finger_bends_about_as_far_at_its_pressures(shipped_finger) -> None:
    tapered = TAPERED.finger()
    shipped, other = (
        finger.angle(factor * 1e5 * finger.pressure_gain).sum()
        for finger, factor in ((shipped_finger, 1.0), (tapered, TAPERED.pressure))
    )
    assert other == pytest.approx(shipped, rel=0.05)


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_stations_have_these_fingers(tmp_path, plant) -> None:
    """Of a scenario whose peg a thicker finger would overlap."""
    station = make_station(plant.scenario("obstructed_outside", tmp_path))
    assert {finger.finger.segments for finger in station.fingers} == {plant.segments}
    assert station.scenario.pressure.steps["all"][-1] == pytest.approx(-50e3 * plant.pressure)
    assert station.scenario.plant_config.time_step == plant.time_step
