import pytest

from soft_gripper.extras.play.simulation_driver import PATIENCE, Pacer

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


@pytest.mark.parametrize(
    ("work", "lasts", "factor"),
    [
        ([0.01] * 200, 200 * FRAME, 1),
        ([2 * FRAME] * 200, 400 * FRAME, 0.5),
        ([PATIENCE / 2, *[0.01] * 100], 101 * FRAME, None),
        ([10.0, *[0.01] * 100], 10 + 100 * FRAME, None),
    ],
    ids=["fast: held back", "slow: not waited for", "hiccup: made up for", "long stop: not made up for"],
)
def test_a_simulation_keeps_to_real_time_and_says_its_factor(
    clock: Clock, work: list[float], lasts: float, factor: float | None
) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, work)
    assert clock.now == pytest.approx(100 + lasts)
    assert factor is None or pacer.factor == pytest.approx(factor)


def test_a_pause_leaves_nothing_to_make_up_for(clock: Clock) -> None:
    pacer = Pacer(clock, clock.pass_by)
    play(pacer, clock, [0.01] * 10)
    clock.pass_by(0.8 * PATIENCE)
    pacer.restart(10 * FRAME)
    assert pacer.factor == 1
    began = clock.now
    play(pacer, clock, [0.01] * 10, begin=10 * FRAME)
    assert clock.now - began == pytest.approx(10 * FRAME)
