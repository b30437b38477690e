import signal
from collections.abc import Iterator

import pytest

from soft_gripper.interrupts import held_back

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """Those of the command line, whatever those of the tests are."""
    before = {number: signal.getsignal(number) for number in NUMBERS}
    for number in NUMBERS:
        signal.signal(number, lambda *_: pytest.fail("it was not held back"))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_is_held_back_and_known(number: signal.Signals) -> None:
    with held_back() as is_interrupted:
        assert not is_interrupted()
        signal.raise_signal(number)
        assert is_interrupted()
        signal.raise_signal(number)
        assert is_interrupted(), "nor does a second one break anything in two"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_signal_that_is_ignored_stays_ignored(number: signal.Signals) -> None:
    signal.signal(number, signal.SIG_IGN)
    with held_back() as is_interrupted:
        signal.raise_signal(number)
        assert not is_interrupted()
    assert signal.getsignal(number) == signal.SIG_IGN
