"""Tables of contacts and of their forces."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.contact_table import (
    ContactRow,
    ContactSummary,
    changes_sign,
    contact_summary,
    contact_table,
    touched_finger_rows,
)
from soft_gripper.extras.paper.forces import LAYOUTS, ContactForceRow, contact_force_table
from soft_gripper.fingers.finger import Finger
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ["pressure.steps.all=[0, 40e3, 80e3]", "pressure.settle=0.1", "pressure.hold_samples=10"]


@pytest.fixture(scope="module")
def rows() -> list[ContactRow]:
    """The left finger touches nothing, one link and three links; the right one nothing, and bends as it is pressed."""
    station = make_station(load_scenario("free_bending", STEPS))
    links = station.fingers[0].finger.segments + 1
    left = np.zeros((3, links))
    left[1, 4] = left[2, 5:7] = left[2, -1] = 0.5
    q = np.full((3, links - 1), 0.05)
    q[1:, 0] = -0.05
    time = np.arange(61) * station.scenario.sensor.period
    step = np.clip((time - 0.005) // 0.2, 0, 2).astype(int)
    values = {
        "left_finger.link_contact_force": left,
        "left_finger.sampled_joint_angles": q,
        "right_finger.link_contact_force": 0 * left,
        "right_finger.sampled_joint_angles": np.abs(q),
    }
    signals = {name: (("time", f"of {value.shape[1]}"), value[step]) for name, value in values.items()}
    return contact_table("made up", station, Recording(xr.Dataset(signals, {"time": time})))


def test_a_row_for_every_finger_and_held_step(rows: list[ContactRow]) -> None:
    ds = 1e3 * load_finger_segment()
    left = [(0.0, 0, 0.0, 0), (40.0, 1, ds, 1), (80.0, 3, 2.5 * ds, 1)]
    right = [(kpa, 0, 0.0, 0) for kpa in (0.0, 40.0, 80.0)]
    found = [(row.pressure_kpa, row.touching_links, row.contact_length_mm, row.sign_changes) for row in rows]
    assert found == [pytest.approx(expected) for expected in (*left, *right)]
    assert [row.finger for row in rows] == ["left_finger"] * 3 + ["right_finger"] * 3
    assert {row.scenario for row in rows} == {"made up"}


def load_finger_segment() -> float:
    """Segment length of the fingers of free bending, m."""
    return make_station(load_scenario("free_bending")).fingers[0].finger.segment_length


def test_the_summary_has_the_most_of_every_scenario(rows: list[ContactRow]) -> None:
    other = [ContactRow("other", "finger", 10.0, 2, 7.0, 0), ContactRow("other", "finger", 20.0, 1, 9.0, 0)]
    made_up, second = contact_summary([*rows, *other])
    assert (made_up.scenario, made_up.touching_links, made_up.sign_changes) == ("made up", 3, 1)
    assert made_up.contact_length_mm == pytest.approx(2.5e3 * load_finger_segment())
    assert second == ContactSummary("other", 2, 9.0, 0)


def test_a_finger_that_stays_free_beside_a_touched_one_is_left_out(rows: list[ContactRow]) -> None:
    free = [ContactRow("free", name, 10.0, 0, 0.0, 0) for name in ("left_finger", "right_finger")]
    kept = touched_finger_rows([*rows, *free], [*rows, *free])
    assert kept == [*rows[:3], *free]


def test_a_joint_is_bent_from_a_radius_of_ten_metres_on(shipped_finger: Finger) -> None:
    """Radii of 8 and of 12 m, the one way, beside one of 1 m, the other way."""
    q = np.full((2, shipped_finger.segments), shipped_finger.segment_length)
    q[:, 0] = -shipped_finger.segment_length / np.array([8.0, 12.0])
    np.testing.assert_array_equal(changes_sign(shipped_finger, q), [True, False])


EXACT = "estimator.uncertainty.bend_per_pressure=0.005"
FORCE_STEPS = (EXACT, "pressure.steps.all=[60e3, -30e3]", "pressure.hold_samples=10")
FINGERS = ("left_finger", "right_finger")


@cache
def obstructed(*overrides: str) -> tuple[Station, Recording]:
    """The left finger closes on a peg and lets go; the right one is free."""
    station = make_station(load_scenario("obstructed_inside", [*FORCE_STEPS, *overrides]))
    return station, run_station(station)


@cache
def table() -> list[ContactForceRow]:
    return contact_force_table("obstructed", *obstructed(), LAYOUTS)


def test_the_truth_is_the_recorded_one_and_near() -> None:
    station, recording = obstructed()
    pressed, free = (next(row for row in table() if row.finger == finger) for finger in FINGERS)
    for column, signal in (
        ("true_n", "true_contact_force"),
        ("total_n", "true_contact_total"),
        ("normal_n", "normal_force"),
    ):
        recorded = held_samples(station.scenario, recording, f"left_finger.{signal}")[0].mean()
        assert getattr(pressed, column) == pytest.approx(recorded)
    recorded = held_samples(station.scenario, recording, "left_finger.true_contact_arc_length")[0].mean()
    assert pressed.true_mm == pytest.approx(1e3 * recorded)
    assert pressed.estimated_n == pytest.approx(pressed.true_n, rel=0.02)
    assert pressed.estimated_mm == pytest.approx(pressed.true_mm, abs=1)
    assert free.true_n == free.estimated_n == 0
    assert np.isnan([free.true_mm, free.estimated_mm]).all()
