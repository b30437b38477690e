"""Contact forces of a run: what the estimator's block puts out, beside the recorded truth."""

from functools import cache

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.forces import LAYOUTS, ContactForceRow, contact_force_table
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.scenario_file import load_scenario

EXACT = "estimator.uncertainty.bend_per_pressure=0.005"
STEPS = (EXACT, "pressure.steps.all=[60e3, -30e3]", "pressure.hold_samples=10")
FINGERS = ("left_finger", "right_finger")


@cache
def obstructed(*overrides: str) -> tuple[Station, Recording]:
    """The left finger closes on a peg and lets go; the right one is free."""
    station = make_station(load_scenario("obstructed_inside", [*STEPS, *overrides]))
    return station, run_station(station)


@cache
def table() -> list[ContactForceRow]:
    return contact_force_table("obstructed", *obstructed(), LAYOUTS)


@pytest.mark.slow
@pytest.mark.parametrize(("sections", "borders"), LAYOUTS)
def test_estimates_are_those_of_the_block(sections: int, borders: tuple[float, ...] | None) -> None:
    sensors = [f"sensor.sections={sections}", *([f"sensor.borders={list(borders)}"] if borders else [])]
    station, recording = obstructed(*sensors, "estimator.type=contact")
    by_block = held_samples(station.scenario, recording, "left_finger.contact_force").mean(axis=1)
    place = held_samples(station.scenario, recording, "left_finger.contact_arc_length").mean(axis=1)
    names = " ".join(f"{1e3 * end * 0.12:g}" for end in borders or np.arange(1, sections) / sections)
    rows = [row for row in table() if (row.finger, row.borders) == (FINGERS[0], names)]
    np.testing.assert_allclose([row.estimated_n for row in rows], by_block, atol=1e-6)
    np.testing.assert_allclose([row.estimated_mm for row in rows], 1e3 * place, atol=1e-3)
    assert by_block[0] > 0.5


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
