import signal
from collections.abc import Iterator

import pytest

from soft_gripper.diagrams.live.interrupts import held_back


def end(number: int, _: object) -> None:
    raise SystemExit(128 + number)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """Those of the command line, whatever those of the tests are."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, end)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(("number", "error"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_signal_waits_until_it_is_let_through(number: signal.Signals, error: type[BaseException]) -> None:
    steps = []
    with pytest.raises(error), held_back() as let_through:  # noqa: PT012
        let_through()
        signal.raise_signal(number)
        steps.append("the frame goes on")
        let_through()
        steps.append("never")
    assert steps == ["the frame goes on"]


def test_afterwards_they_are_as_before() -> None:
    with held_back():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_who_ignores_ctrl_c_goes_on_ignoring_it() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with held_back() as let_through:
        signal.raise_signal(signal.SIGINT)
        let_through()
    assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
