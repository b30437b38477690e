"""Tables of steps and phases."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from pick_and_place import recording
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.control.task import Outcome, Phase
from soft_gripper.diagrams.recording import Recording
from soft_gripper.runs.scores import steps as module
from soft_gripper.runs.scores.steps import outcome, phase_table, step_table

PERIOD, HOLD = 0.01, 4.0


def rows(monkeypatch, response, set_points=(0.05,), begin=0.09, true_error=0.0):
    """The table of an opening that follows every set point by the unit step response, a function of time."""
    time = np.arange(round(len(set_points) * HOLD / PERIOD) + 1) * PERIOD
    opening, last = np.full(len(time), begin), begin
    for step, end in enumerate(set_points):
        during = time > step * HOLD + 1e-9
        opening[during] = last + (end - last) * response(time[during] - step * HOLD)
        last = opening[round((step + 1) * HOLD / PERIOD)]
    data = xr.Dataset({"grip.opening": ("time", opening)}, {"time": time})
    control = SimpleNamespace(hold=HOLD, set_points=list(set_points))
    station = SimpleNamespace(scenario=SimpleNamespace(control=control))
    monkeypatch.setattr(module, "true_opening", lambda *_: opening + true_error)
    return step_table(station, Recording(data))


def first_order(time, constant=0.2):
    return 1 - np.exp(-time / constant)


def second_order(time, damping=0.5, frequency=8.0):
    damped = frequency * np.sqrt(1 - damping**2)
    wave = np.cos(damped * time) + damping * frequency / damped * np.sin(damped * time)
    return 1 - np.exp(-damping * frequency * time) * wave


@pytest.mark.parametrize("end", [0.05, 0.12], ids=["closing", "opening"])
def test_first_order_settles_without_overshoot(monkeypatch, end):
    (row,) = rows(monkeypatch, first_order, [end])
    assert (row.from_mm, row.to_mm) == pytest.approx((90, end * 1e3))
    assert row.overshoot_percent == 0
    assert row.settling_s == pytest.approx(0.2 * np.log(50), abs=PERIOD)


@pytest.mark.parametrize("damping", [0.3, 0.5, 0.7])
def test_overshoot_of_second_order(monkeypatch, damping):
    (row,) = rows(monkeypatch, lambda time: second_order(time, damping))
    expected = 100 * np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
    assert row.overshoot_percent == pytest.approx(expected, rel=0.01)


def test_settling_of_second_order_is_the_last_entry_into_the_band(monkeypatch):
    (row,) = rows(monkeypatch, second_order)
    time = np.arange(0, HOLD, 1e-4)
    last_outside = time[np.abs(second_order(time) - 1) > 0.02][-1]
    assert row.settling_s == pytest.approx(last_outside, abs=1.01 * PERIOD)


def test_steady_errors_are_signed_and_apart(monkeypatch):
    (row,) = rows(monkeypatch, lambda time: 0.99 * first_order(time, 0.1), [0.05], true_error=-3e-4)
    assert row.steady_error_estimated_mm == pytest.approx(0.4, rel=1e-6)
    assert row.steady_error_true_mm == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("damping", [0.1, 0.3, 0.9])
def test_crossings_of_second_order_are_its_half_waves_that_leave_the_band(monkeypatch, damping):
    """Every half wave is smaller than the one before by exp(-pi damping / sqrt(1 - damping^2))."""
    (row,) = rows(monkeypatch, lambda time: second_order(time, damping, frequency=20.0))
    assert row.crossings == int(np.log(50) / (np.pi * damping / np.sqrt(1 - damping**2)))


def test_what_swings_about_the_set_point_has_no_steady_error(monkeypatch):
    """Whole periods of a sine: its mean over the last half second is 0, its largest value is not."""
    (row,) = rows(monkeypatch, lambda time: 1 + 0.01 * np.sin(2 * np.pi * time / 0.1))
    assert row.steady_error_estimated_mm == pytest.approx(0.0, abs=1e-9)


STAY = PiecewisePolynomial(np.zeros((6, 1)))
NAMES = ("approach", "close", "lift", "rescue: open", "rescue: home")
PHASES = [Phase(name, STAY, 0.05, i + 1) for i, name in enumerate(NAMES)]
STATION = SimpleNamespace(task=SimpleNamespace(phases=PHASES), fingers=[SimpleNamespace(name="left_finger")])


def recorded(phase, ended=Outcome.DONE):
    """Opening, torque and pressure count the sample, which every 10 ms brings."""
    sample = np.arange(len(phase), dtype=float)
    return recording(
        {
            "task.phase": np.array(phase, dtype=float),
            "task.outcome": np.where(sample < len(phase) - 1, Outcome.RUNNING, ended).astype(float),
            "grip.opening": 1e-3 * sample,
            "grip.torque": -2e-3 * sample,
            "left_finger.sampled_pressure": 4e3 * sample,
        }
    )


def values(row):
    return [row.began_s, row.lasted_s, row.opening_mm, row.torque_mnm, row.pressure_kpa]


def test_a_row_for_every_phase_with_what_was_read_at_its_end():
    rows = phase_table(STATION, recorded([0, 0, 0, 1, 1, 2, 2, 2, 2, 5, 5]))
    assert [row.phase for row in rows] == ["approach", "close", "lift"]
    expected = [[0.0, 0.03, 3, -6, 12], [0.03, 0.02, 5, -10, 20], [0.05, 0.04, 9, -18, 36]]
    np.testing.assert_allclose([values(row) for row in rows], expected, atol=1e-12)


@pytest.mark.parametrize("ended", Outcome)
def test_outcome_is_that_at_the_end(ended):
    found = outcome(recorded([0, 1, 2, 5], ended))
    assert isinstance(found, Outcome)
    assert found == ended
