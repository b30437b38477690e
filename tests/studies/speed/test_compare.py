"""Checkouts are compared with nothing of their recordings read, and with every signal read."""

import json
import sys

import numpy as np
import pytest

from soft_gripper import dump_scenario, load_scenario
from soft_gripper.array_block import ArrayBlock
from studies.speed import compare, timed_run

READ = json.dumps({"closed": [1.0], "read": [0.5], "bare": [0.5]})
UNREAD = json.dumps({"closed": [1.0], "bare": [0.5]})


def checkout(folder, printed):
    """A folder with a Python and a timed_run.py that prints a text."""
    (folder / ".venv/bin").mkdir(parents=True)
    (folder / ".venv/bin/python").symlink_to(sys.executable)
    (folder / "studies/speed").mkdir(parents=True)
    (folder / compare.TIMED_RUN).write_text(f"print({printed!r})", encoding="utf-8")
    return folder


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


def test_a_gain_of_what_is_not_read_shows():
    """Half of the time if nothing is read, all of it if everything is."""
    times = {
        **{("other", "closed"): 2.0, ("other", "read"): 0.0, ("other", "bare"): 0.5},
        **{("here", "closed"): 1.0, ("here", "read"): 1.0, ("here", "bare"): 0.6},
    }
    assert dict(compare.ratios(times)) == {"none": (2.0, 0.5 / 1.5, 4.0, 2.0), "all": (1.0, 1.0, 4.0, 4.0)}


def test_a_checkout_that_reads_nothing_is_timed_by_this_one(tmp_path, monkeypatch):
    old, new = checkout(tmp_path / "old", UNREAD), checkout(tmp_path / "new", READ)
    monkeypatch.setattr(compare, "ROOT", new)
    monkeypatch.setattr(compare, "ROUNDS", 1)
    assert compare.timed_run(old, "box_grasp") == json.loads(READ)
    assert compare.run_in_turns(old, "box_grasp")["other", "read"] == [[0.5]]
