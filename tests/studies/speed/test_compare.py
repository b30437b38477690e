"""Checkouts are compared with nothing of their recordings read, and with every signal read."""

import json

import numpy as np
import pytest

from soft_gripper import dump_scenario, load_scenario
from soft_gripper.array_block import ArrayBlock
from studies.speed import timed_run


def test_a_run_is_timed_with_every_signal_read(tmp_path, capsys, monkeypatch):
    """Afterwards no block computes anything, of the recording of the whole run."""
    steps = ["pressure.steps.all=[60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]
    scenario, recordings = load_scenario("free_bending", steps), []
    (tmp_path / "short.yaml").write_text(dump_scenario(scenario), encoding="utf-8")
    read_all = timed_run.read_all
    monkeypatch.setattr(timed_run, "read_all", lambda recording: recordings.append(recording) or read_all(recording))
    monkeypatch.setattr(timed_run, "PART", 0.05)
    timed_run.main(str(tmp_path / "short.yaml"))
    times = json.loads(capsys.readouterr().out)
    assert times.keys() == {"closed", "read", "bare"}
    assert times["read"][0] > 0
    monkeypatch.setattr(ArrayBlock, "output_over_time", lambda *_: pytest.fail("a signal was not read"))
    assert [len(recording["time"]) for recording in recordings] == [1, 26]
    assert all(np.size(recordings[1][name].values) for name in recordings[1].signals)
