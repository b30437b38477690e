"""What the tests of a task's rules share: its times, its threshold, and motions."""

from pydrake.trajectories import PiecewisePolynomial

T = 0.01  # s
LATE = 2 * T  # what sampling may add to a time
LONG = 60.0  # s
THRESHOLD = 0.02  # N m
TIMEOUT = 2.0  # s


def motion(duration):
    return PiecewisePolynomial.FirstOrderHold([0.0, duration], [[0.0, 1.0]])
