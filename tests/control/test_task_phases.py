"""Phases of a task, led by what the gripper reports: grasps, carries, releases, failures, and an open gripper."""

import numpy as np
import pytest
from task_rules import LATE, LONG, THRESHOLD, TIMEOUT, T, motion

from soft_gripper.control.task import (
    CLOSING_ALLOWANCE,
    GRIP_GAP,
    OPENED_BAND,
    QUIET_BAND,
    QUIET_TIME,
    GripObservation,
    Outcome,
    Phase,
    Progress,
    Rules,
)

OPEN, NARROW, AT_HOME = 0.1, 0.03, 0.08  # m, set points
GRIP = 0.05  # m, where the tips rest on the object
CLOSING = 0.3  # s, of the arm's motion in the meantime
HARD, SOFT = 0.05, 0.01  # N m, more and less than a grip
NAN = np.nan
REACH, CLOSE, LIFT, CARRY, RELEASE, RETURN, LET_GO, HOME, OVER = range(9)


RULES = Rules(
    (
        Phase("reach", motion(0.5), OPEN, CLOSE, rest=0.2),
        Phase("close", motion(CLOSING), NARROW, LIFT, until="grasped", rescue=LET_GO),
        Phase("lift", motion(0.6), NARROW, CARRY, holds=True, rescue=LET_GO),
        Phase("carry", motion(0.4), NARROW, RELEASE, holds=True, rescue=LET_GO),
        Phase("release", motion(0.1), OPEN, RETURN, until="released", rescue=LET_GO),
        Phase("return", motion(0.5), AT_HOME, OVER),
        Phase("let go", motion(0.1), OPEN, HOME, rest=0.3),
        Phase("home", motion(0.4), AT_HOME, OVER),
    ),
    THRESHOLD,
    TIMEOUT,
)


class Script:
    """A task under way: it is given what is estimated, and notes what comes of it."""

    def __init__(self):
        self.progress, self.time = Progress(), 0.0
        self.began = {}  # s, of every phase but the first
        self.failed = None  # s

    def observe(self, opening, torque, lasting=LONG):
        """Observes the same, or functions of time, until the phase changes or the time is up."""
        phase = self.progress.phase
        for _ in range(round(lasting / T)):
            values = (value(self.time) if callable(value) else value for value in (opening, torque))
            self.progress = RULES.step(self.progress, GripObservation(self.time, *values))
            if self.failed is None and self.progress.outcome > Outcome.DONE:
                self.failed = self.time
            changed = self.progress.phase != phase
            if changed:
                self.began[self.progress.phase] = self.time
            self.time = round(self.time + T, 9)
            if changed:
                break
        return self

    @property
    def set_point(self):
        return RULES.opening(self.progress)

    @property
    def outcome(self):
        return self.progress.outcome


def until_close():
    return Script().observe(OPEN, 0.0)


def until_lift():
    return until_close().observe(GRIP, HARD)


def until_release():
    return until_lift().observe(GRIP, HARD).observe(GRIP, HARD)


def assert_rescued(script):
    """The fingers are open, the arm goes home, and the failure remains."""
    outcome = script.outcome
    assert script.set_point == OPEN
    script.observe(OPEN, 0.0)
    assert (script.progress.phase, script.outcome, script.set_point) == (HOME, outcome, AT_HOME)
    script.observe(OPEN, 0.0)
    assert (script.progress.phase, script.outcome, script.set_point) == (OVER, outcome, AT_HOME)
    assert list(script.began)[-3:] == [LET_GO, HOME, OVER]
    assert script.began[HOME] - script.began[LET_GO] == pytest.approx(0.1 + 0.3, abs=LATE)
    assert script.began[OVER] - script.began[HOME] == pytest.approx(0.4, abs=LATE)


def test_a_task_that_succeeds():
    script = until_release()
    set_points = [script.set_point]
    script.observe(OPEN, 0.0)
    set_points.append(script.set_point)
    script.observe(OPEN, 0.0)
    lasted = np.diff([0.0, *script.began.values()])
    assert list(script.began) == [CLOSE, LIFT, CARRY, RELEASE, RETURN, OVER]
    # Motion and rest; motion; motion; motion; quiet; motion.
    np.testing.assert_allclose(lasted, [0.7, CLOSING, 0.6, 0.4, QUIET_TIME, 0.5], atol=LATE)
    assert set_points == [OPEN, AT_HOME]
    assert (script.outcome, script.failed) == (Outcome.DONE, None)


def test_a_grasp_waits_until_the_tips_are_at_rest():
    """While they close, however slowly, a torque is no grip."""
    slow, stop = 2 * QUIET_BAND / QUIET_TIME, 1.5  # m/s, s
    script = until_close()
    start = script.time
    script.observe(lambda time: GRIP - slow * min(time - start, stop), HARD)
    # The last time that the tips leave the band is up to a band before they stop.
    waited = script.began[LIFT] - start - stop
    assert QUIET_TIME - QUIET_BAND / slow - LATE <= waited <= QUIET_TIME + LATE


@pytest.mark.parametrize(
    ("opening", "torque"),
    [
        (lambda time: GRIP + 2 * QUIET_BAND * (round(time / T) % 2), HARD),
        (NAN, HARD),
        (NAN, NAN),
        (np.inf, NAN),
    ],
    ids=["restless", "no opening", "nothing known", "infinite"],
)
def test_a_grasp_that_does_not_come_is_given_up(opening, torque):
    script = until_close().observe(opening, torque)
    assert script.outcome == Outcome.NOTHING_GRASPED
    assert script.began[LET_GO] - script.began[CLOSE] == pytest.approx(CLOSING + TIMEOUT, abs=LATE)
    assert_rescued(script)


@pytest.mark.parametrize(
    ("opening", "torque"),
    [(GRIP, SOFT), (GRIP, NAN), (GRIP - 1.1 * CLOSING_ALLOWANCE, HARD), (NAN, HARD)],
    ids=["no torque", "torque unknown", "tips too near", "opening unknown"],
)
def test_object_lost_in_the_air(opening, torque):
    """The fingers open at once; the motion is ended, and then the arm goes home."""
    script = until_lift().observe(GRIP, HARD, lasting=0.2)
    slipped = script.time
    script.observe(opening, torque)
    assert script.outcome == Outcome.OBJECT_LOST
    assert script.failed - slipped == pytest.approx(GRIP_GAP, abs=LATE)
    assert script.began[LET_GO] - script.began[LIFT] == pytest.approx(0.6, abs=LATE)
    assert_rescued(script)


def test_the_set_point_opens_with_the_failure():
    script = until_lift().observe(GRIP, SOFT, lasting=GRIP_GAP - T)
    assert (script.outcome, script.set_point) == (Outcome.RUNNING, NARROW)
    script.observe(GRIP, SOFT, lasting=3 * T)
    assert (script.progress.phase, script.outcome, script.set_point) == (LIFT, Outcome.OBJECT_LOST, OPEN)


def test_a_failure_is_not_forgotten_when_the_grip_comes_back():
    script = until_lift().observe(GRIP, SOFT, lasting=2 * GRIP_GAP).observe(GRIP, HARD)
    assert script.outcome == Outcome.OBJECT_LOST
    assert_rescued(script)


def test_a_grip_may_be_missed_for_a_moment():
    script = until_lift()
    for _ in range(2):
        script.observe(GRIP, SOFT, lasting=GRIP_GAP - 2 * T).observe(NAN, NAN, lasting=T).observe(GRIP, HARD, lasting=T)
    assert script.observe(GRIP, HARD).progress.phase == CARRY
    assert script.outcome == Outcome.RUNNING


def test_tips_may_come_a_little_nearer_than_when_they_grasped():
    assert until_lift().observe(GRIP - 0.9 * CLOSING_ALLOWANCE, HARD).progress.phase == CARRY


def test_not_released():
    script = until_release().observe(OPEN, HARD)
    assert script.outcome == Outcome.NOT_RELEASED
    assert script.began[LET_GO] - script.began[RELEASE] == pytest.approx(0.1 + TIMEOUT, abs=LATE)
    assert_rescued(script)


def test_nothing_is_released_while_the_tips_move_or_are_unknown():
    script = until_release().observe(lambda time: GRIP + 0.01 * time, 0.0, lasting=1.0).observe(NAN, 0.0, lasting=0.5)
    assert script.progress.phase == RELEASE
    script.observe(OPEN, 0.0)
    assert (script.progress.phase, script.outcome) == (RETURN, Outcome.RUNNING)


HOOKED = -0.1  # N m, of fingers that hold each other


def test_fingers_that_hold_each_other_have_released_nothing():
    script = until_release().observe(GRIP, HOOKED)
    assert script.outcome == Outcome.NOT_RELEASED


def test_a_rescue_gives_up_waiting_and_goes_on():
    """Nothing rescues a rescue: the arm goes home though the fingers do not let go."""
    rescue = (Phase("let go", motion(0.1), OPEN, 1, until="released"), Phase("home", motion(0.4), AT_HOME, 2))
    rules, progress, began = Rules(rescue, THRESHOLD, TIMEOUT), Progress(outcome=Outcome.OBJECT_LOST), None
    for time in np.arange(0.0, 5.0, T):
        progress = rules.step(progress, GripObservation(time, GRIP, HOOKED))
        began = time if began is None and progress.phase == 1 else began
    assert began == pytest.approx(0.1 + TIMEOUT, abs=LATE)
    assert (progress.phase, progress.outcome) == (2, Outcome.OBJECT_LOST)


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
