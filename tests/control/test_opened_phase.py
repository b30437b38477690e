"""A phase that waits until the gripper is open, led through by scripted openings."""

import numpy as np
import pytest
from task_rules import LATE, LONG, THRESHOLD, TIMEOUT, T, motion

from soft_gripper.control.task import (
    OPENED_BAND,
    QUIET_BAND,
    QUIET_TIME,
    GripObservation,
    Outcome,
    Phase,
    Progress,
    Rules,
)

OPEN, AT_HOME = 0.1, 0.08  # m, set points
NAN = np.nan


AWAIT_OPEN = Rules(
    (
        Phase("approach", motion(0.5), OPEN, 1, until="opened", rescue=2),
        Phase("descend", motion(0.5), OPEN, 3),
        Phase("home", motion(0.4), OPEN, 3),
    ),
    THRESHOLD,
    TIMEOUT,
)


def after_approach(opening):
    """The phase that follows the approach, when, s, and the outcome; `opening` is a function of time."""
    progress = Progress()
    for time in np.arange(0.0, LONG, T):
        progress = AWAIT_OPEN.step(progress, GripObservation(time, opening(time), 0.0))
        if progress.phase != 0:
            return progress.phase, time, progress.outcome
    raise AssertionError("the approach does not end")


def test_an_open_gripper_waits_for_the_motion_only():
    for opening in (OPEN - 0.9 * OPENED_BAND, OPEN + 0.9 * OPENED_BAND):
        assert after_approach(lambda _, opening=opening: opening) == (1, pytest.approx(0.5, abs=LATE), Outcome.RUNNING)


def test_opened_waits_until_the_tips_have_come_to_rest_at_the_commanded_opening():
    late = 1.195  # s
    phase, time, outcome = after_approach(lambda time: OPEN if time > late else AT_HOME)
    assert (phase, time, outcome) == (1, pytest.approx(late + QUIET_TIME, abs=LATE), Outcome.RUNNING)


@pytest.mark.parametrize(
    "opening",
    [
        lambda _: OPEN - 1.1 * OPENED_BAND,
        lambda _: OPEN + 1.1 * OPENED_BAND,
        lambda time: OPEN + 2 * QUIET_BAND * (round(time / T) % 2),
        lambda _: NAN,
    ],
    ids=["too narrow", "too wide", "restless", "unknown"],
)
def test_a_gripper_that_does_not_open_does_not_descend(opening):
    assert after_approach(opening) == (2, pytest.approx(0.5 + TIMEOUT, abs=LATE), Outcome.NOT_OPENED)
