"""Progress of calls that are made elsewhere."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from soft_gripper.extras.hardware import progress


def test_what_takes_long_is_reported_while_it_takes(monkeypatch, capsys):
    """The elapsed time goes on although no call ends; and what one raises is left to its future."""
    reports, end = [], Event()

    class Bar(progress.tqdm):
        def refresh(self, *arguments, **options):
            reports.append(self.n)
            if reports.count(0) > 3:
                end.set()
            return super().refresh(*arguments, **options)

    monkeypatch.setattr(progress, "tqdm", Bar)
    monkeypatch.setattr(progress, "_LOG_PERIOD", 0.01)
    with ThreadPoolExecutor() as executor:
        calls = [executor.submit(end.wait, 10.0), executor.submit(lambda: 1 / int(not end.wait(10.0)))]
        progress.wait_for(calls, "left out", "family")
    assert reports.count(0) > 3
    assert reports[-1] == 2
    assert "left out" in capsys.readouterr().err
    with pytest.raises(ZeroDivisionError):
        calls[1].result()
