import pytest

from soft_gripper.extras.play.pacer import PATIENCE, Pacer

FRAME = 0.05


class Clock:
    """Real time that passes when somebody sleeps or works."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def pass_by(self, duration: float) -> None:
        assert duration >= 0
        self.now += duration


@pytest.fixture
def clock() -> Clock:
    return Clock()


def play(pacer: Pacer, clock: Clock, work: list[float], begin: float = 0.0) -> None:
    """Frames that take as long as `work` says."""
    for i, duration in enumerate(work, start=1):
        clock.pass_by(duration)
        pacer.keep(begin + i * FRAME)


def test_a_fast_simulation_is_held_back(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [0.01] * 200)
    assert clock.now == pytest.approx(100 + 200 * FRAME)
    assert pacer.factor == pytest.approx(1)


def test_a_slow_simulation_is_not_waited_for_and_says_its_factor(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [2 * FRAME] * 200)
    assert clock.now == pytest.approx(100 + 400 * FRAME)
    assert pacer.factor == pytest.approx(0.5)


def test_a_hiccup_is_made_up_for(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [PATIENCE / 2, *[0.01] * 100])
    assert clock.now == pytest.approx(100 + 101 * FRAME)


def test_a_long_stop_is_not(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [10.0, *[0.01] * 100])
    assert clock.now == pytest.approx(100 + 10 + 100 * FRAME)


def test_the_factor_is_of_late(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [4 * FRAME] * 100)
    play(pacer, clock, [0.01] * 100, begin=100 * FRAME)
    assert pacer.factor == pytest.approx(1, rel=0.03)


def test_a_pause_leaves_nothing_to_make_up_for(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [0.01] * 10)
    clock.pass_by(0.8 * PATIENCE)
    pacer.restart(10 * FRAME)
    assert pacer.factor == 1
    began = clock.now
    play(pacer, clock, [0.01] * 10, begin=10 * FRAME)
    assert clock.now - began == pytest.approx(10 * FRAME)
