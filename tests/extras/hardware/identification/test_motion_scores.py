"""What people look at, against signals of which it is known."""

from dataclasses import replace

import numpy as np
import pytest
from identified import CLOSES, OPENS, REFERENCE, RELEASE, recorded, release, step

from soft_gripper.extras.hardware.identification.fit import _swing, _time_below, score, turn_response
from soft_gripper.extras.hardware.identification.free_parameters import Model

MIDDLE = REFERENCE.mean()


def turning(motion, turn):
    """Markers that turn about their middle by an angle, rad, and are displaced by 5 cm a radian."""
    return MIDDLE + 0.05j * turn[:, None] + np.exp(1j * turn)[:, None] * (REFERENCE - MIDDLE)


@pytest.mark.parametrize(("frequency", "decrement"), [(3.0, 0.2), (7.3, 0.4), (5.1, 0.05)])
def test_swings_of_a_damped_cosine(frequency, decrement):
    time = np.arange(-0.3, 3, 0.01)
    swing = 1 - np.exp(-decrement * frequency * time) * np.cos(2 * np.pi * frequency * time)
    found = _swing(time, np.where(time < 0, 0, swing), 3.0)
    assert found[0] == pytest.approx(frequency, rel=2e-3)
    assert found[1] == pytest.approx(decrement, rel=0.05, abs=2e-3)


def test_turn_of_an_exponential_that_creeps():
    motion = release(4.0)
    since = np.maximum(motion.time - RELEASE, 0)
    turn = 0.4 * (1 - np.exp(-since / 0.03)) + 0.02 * since
    found = turn_response(motion, turning(motion, turn))
    end = motion.time[-1] - RELEASE
    assert found.settled == pytest.approx(0.4 + 0.02 * (end - 0.1), abs=2e-4)
    assert found.creep == pytest.approx(0.02 * (end - 0.1 - 0.5), abs=1e-3)

    def reaches(level):
        fine = np.linspace(0, 1, 100001)
        return fine[np.argmax(0.4 * (1 - np.exp(-fine / 0.03)) + 0.02 * fine >= level)]

    assert found.t50 == pytest.approx(reaches(0.5 * found.settled), abs=3e-3)
    assert found.t63 == pytest.approx(reaches(0.63 * found.settled), abs=3e-3)
    assert np.isnan(found.recovery)


def test_a_swing_that_only_just_crosses_a_level_does_not_change_the_time_below_it():
    """A first crossing would jump by most of a period of 125 ms; a slow mean crosses the level where the swing does."""
    time = np.arange(0, 2, 1e-3)
    mean, swing = np.minimum(time / 0.5, 1), np.sin(2 * np.pi * 8 * time)
    assert _time_below(time, mean, 0.63) == pytest.approx(0.315, abs=1e-3)
    assert _time_below(time, mean + 0.2 * swing, 0.63) == pytest.approx(0.315, abs=0.02)
    peak = float(np.max((mean + 0.2 * swing)[time < 0.25]))
    little = [_time_below(time, mean + 0.2 * swing, peak + by) for by in (-1e-3, 1e-3)]
    first = [time[np.argmax(mean + 0.2 * swing >= peak + by)] for by in (-1e-3, 1e-3)]
    assert np.diff(first) > 0.06
    assert np.diff(little) == pytest.approx(0.0, abs=0.012)


def test_the_time_below_a_level_leaves_out_what_was_not_seen():
    time = np.arange(0, 1, 0.01)
    turn = np.where((time > 0.2) & (time < 0.3), np.nan, time)
    assert _time_below(time, turn, 0.6) == pytest.approx(0.6)
    assert np.isnan(_time_below(time, turn, 1.5))


def test_recovery_is_seen_after_the_valve_has_closed():
    motion = step(3e4, 6.0)
    emptied = np.maximum(motion.time - CLOSES, 0)
    turn = np.where(motion.time < CLOSES, 0.3 * (motion.time > OPENS), 0.02 + 0.05 * np.exp(-emptied / 0.7))
    found = turn_response(motion, turning(motion, turn))
    assert found.recovery == pytest.approx(0.05 * (np.exp(-0.5 / 0.7) - np.exp(-4.7 / 0.7)), rel=0.02)


def test_recovery_is_not_known_where_a_recording_ends_soon_after_the_valve_has_closed():
    motion = step(3e4, CLOSES + 0.7)
    turn = np.where(motion.time < CLOSES, 0.3 * (motion.time > OPENS), 0.02)
    assert np.isnan(turn_response(motion, turning(motion, turn)).recovery)


def test_errors_of_markers_to_either_side_do_not_make_up_for_each_other(beam):
    """Two markers 2 mm beside the simulated ones, one on either side, and a third where it is: 4/3 mm in the mean."""
    motion = recorded(beam, release())
    apart = replace(motion, markers=motion.markers + 0.002j * np.array([1, -1, 0]))
    found = score(Model(beam), apart, "test")
    assert found.settled_error_mm == pytest.approx(4 / 3, rel=0.02)
    assert found.motion_error_mm == pytest.approx(4 / 3, rel=0.02)
    assert found.tip_error_percent < 0.05  # of their middle


def test_what_is_before_the_event_counts_for_nothing(beam):
    motion = recorded(beam, release())
    before = motion.time < motion.events[0]
    assert before.any()
    shaken = replace(motion, markers=motion.markers + 0.002j * before[:, None])
    found, calm = (score(Model(beam), each, "test") for each in (shaken, motion))
    assert (found.motion_error_mm, found.tip_error_percent) == (calm.motion_error_mm, calm.tip_error_percent)
