"""What is recorded live, and threads that hold nothing up."""

import errno
import threading
import time

import numpy as np
import pytest
from refusals import refused
from waiting import LONG, wait_until

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.bench import recorder as recorder_module
from soft_gripper.extras.bench import threads
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import recorded_signals
from soft_gripper.extras.bench.recorder import Recorder, free_name, recording_layout
from soft_gripper.extras.bench.threads import ROOM, Inbox, Outbox
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs
from soft_gripper.scenario.scenario_file import load_scenario

SCENARIO = load_scenario("tip_distance_steps", ["estimator.type=gaussian"])


@pytest.fixture(scope="module")
def bench():
    return Bench(SCENARIO)


def recorder(bench, path):
    return Recorder(
        bench, recording_layout(bench, recorded_signals(bench, bench_from_inputs(bench.inputs, "test"))), path
    )


def feed(bench, recorder, begin, end):
    for i in range(begin, end):
        bench.step({name: 1e-3 * i + np.arange(size) for name, size in bench.inputs.items()})
        recorder.take(float(i), 0.01 * i)


def test_it_has_every_sample(bench, tmp_path):
    path = tmp_path / "recording.nc"
    found = recorder(bench, path)
    feed(bench, found, 0, 50)
    found.close()
    data = Recording.load(path).data
    np.testing.assert_allclose(data["time"], 0.01 * np.arange(50))
    np.testing.assert_array_equal(data["reading.count"], np.arange(50))
    np.testing.assert_array_equal(data["left_finger.strain"].values.reshape(50, -1)[7], 7e-3 + np.arange(8))
    for name in ("left_finger.tip_pose", "right_finger.estimated_joint_angles", "left_finger.pressure_command"):
        np.testing.assert_array_equal(data[name].values[-1].ravel(), bench.read([name])[name])
    assert data["left_finger.tip_pose"].dims == ("time", "pose")
    assert data["left_finger.strain"].attrs["units"] == "1"
    assert found.report == f"written: {path}"


def test_it_can_be_read_at_any_time_and_torn_anywhere(bench, tmp_path):
    """What a killed process leaves: rows that are counted, and perhaps a part of one that is not."""
    path, torn = tmp_path / "recording.nc", tmp_path / "torn.nc"
    found = recorder(bench, path)
    assert Recording.load(path).data.sizes["time"] == 0
    feed(bench, found, 0, 20)
    wait_until(lambda: Recording.load(path).data.sizes["time"] == 20)
    found.close()
    torn.write_bytes(path.read_bytes() + bytes(100))
    assert Recording.load(torn).data.equals(Recording.load(path).data)


def test_a_full_disk_costs_what_follows_alone(bench, tmp_path, monkeypatch):
    path = tmp_path / "recording.nc"
    found = recorder(bench, path)
    feed(bench, found, 0, 5)
    wait_until(lambda: Recording.load(path).data.sizes["time"] == 5)

    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(recorder_module, "write_all", fail)
    feed(bench, found, 5, 8)
    found.close()
    assert Recording.load(path).data.sizes["time"] == 5
    assert found.report == f"written: {path}; 3 samples are missing: No space left on device"


def test_no_recording_replaces_another(bench, tmp_path):
    path = tmp_path / "recording.nc"
    assert free_name(path) == path
    path.write_text("kept")
    with refused("recording", str(path)):
        recorder(bench, path)
    assert free_name(path) == tmp_path / "recording_2.nc"
    assert path.read_text() == "kept"


AT_ONCE = 3.0  # s, on a busy machine


def test_what_nobody_takes_is_dropped_but_the_newest(monkeypatch):
    monkeypatch.setattr(threads, "LINGER", 0.1)
    goes_on, taken = threading.Event(), []
    outbox = Outbox(lambda item: (goes_on.wait(), taken.append(item)))
    began = time.monotonic()
    for i in range(1000):
        outbox.put(i)
    assert time.monotonic() - began < AT_ONCE
    assert outbox.dropped >= 1000 - ROOM - 1
    goes_on.set()
    outbox.close()
    assert taken[-1] == 999
    assert outbox.dropped + len(taken) == 1000


def test_a_signal_ends_waiting_for_room(monkeypatch):
    monkeypatch.setattr(threads, "LINGER", 0.1)
    is_over = threading.Event()
    outbox = Outbox(lambda _: threading.Event().wait(), is_over.is_set)
    threading.Timer(0.2, is_over.set).start()
    for i in range(2 * ROOM):
        outbox.put(i)
    outbox.close()
    assert outbox.dropped == 2 * ROOM


def test_a_generator_that_waits_holds_nothing_up():
    goes_on = threading.Event()

    def messages():
        yield {"a": 1.0}
        goes_on.wait()
        yield {"a": 2.0}
        raise ZeroDivisionError

    inbox = Inbox(messages(), 0.0)
    assert inbox.receive(LONG) == [{"a": 1.0}]
    assert inbox.receive(0.01) == []
    assert not inbox.is_over
    goes_on.set()
    assert inbox.receive(LONG) == [{"a": 2.0}]
    with pytest.raises(ZeroDivisionError):
        inbox.receive(LONG)
    assert inbox.is_over
