"""Bags of ROS 1 and 2 and MCAP files: rows and columns of their messages, and what is refused."""

from contextlib import suppress

import numpy as np
import pytest
from hardware_files import MARKERS, swinging
from refusals import refused

rosbags = pytest.importorskip("rosbags", reason="bags take rosbags and mcap: pip install 'soft-gripper[ros]'")
from bag_files import NUMBERS, POINT, write_json_mcap, write_named, write_ros  # noqa: E402
from damaged_files import damaged_bytes  # noqa: E402
from rosbags.rosbag2 import StoragePlugin  # noqa: E402

from soft_gripper.errors import InputError  # noqa: E402
from soft_gripper.extras.hardware import isolated_reading  # noqa: E402
from soft_gripper.extras.hardware.recordings import read_recording  # noqa: E402
from soft_gripper.extras.hardware.table import Columns  # noqa: E402
from soft_gripper.extras.hardware.table_files import read_table  # noqa: E402  # noqa: E402
from soft_gripper.files.notes import collect_notes  # noqa: E402

OF_BAG = """
time: /m/tip_1.header.stamp
length: 0.1
markers:
  columns: "/m/{marker}.point.{axis}"
  unit: mm
  bodies: {tip: [tip_1, tip_2, tip_3], base: [base_1]}
frame: {origin: [0, 0, 0]}
pressures: {columns: ["/pressure.position[0]"], unit: kPa}
"""
FORMATS = {
    "a.bag": write_ros,
    "sqlite": lambda *args: write_ros(*args, plugin=StoragePlugin.SQLITE3),
    "mcap": lambda *args: write_ros(*args, plugin=StoragePlugin.MCAP),
    "a.mcap": write_json_mcap,
}
KINDS = {f"/m/{name}": POINT for name in MARKERS}


def with_pressure():
    """Columns of a recording, and a pressure."""
    columns = swinging()
    return columns | {"kPa": 10.0 + np.arange(len(columns["time_s"])) // 2}


def series(columns):
    """The same as topics; the pressure is sent half as often."""
    time = columns["time_s"]
    points = {f"/m/{m}": (time, np.column_stack([columns[f"{m}_{axis}_mm"] for axis in "xyz"])) for m in MARKERS}
    return {**points, "/pressure": (time[::2], columns["kPa"][::2, None])}


def test_rows_without_a_message_are_counted(tmp_path):
    """In the words and with the code of tables; rows before the first message are left out, if it comes in time."""
    time = np.arange(100) / 100
    slow = (time[[5, 50]], np.array([[1.0], [2.0]]))
    path = write_ros(tmp_path / "a.bag", {"/fast": (time, time[:, None]), "/slow": slow})
    with collect_notes() as notes:
        found = read_table(path, Columns({"/slow.position[0]": "readings"}, "/fast.header.stamp"))
    assert found.values[0].tolist() == [0.05, 1.0]
    assert [f"{note.subject}: {note.why}" for note in notes] == [
        "5 of 100 rows: some signals began after them",
        "73 of 95 cells of /slow.position[0]: no value there, nor in the 0.1 s before (`hold`)",
    ]
    longer = read_table(path, Columns({"/slow.position[0]": "readings"}, "/fast.header.stamp", hold=1.0)).values[:, 1]
    np.testing.assert_array_equal(longer, np.where(time[5:] < 0.5, 1.0, 2.0))


def test_messages_without_a_stamp_are_ordered_by_when_they_were_recorded(tmp_path):
    time = np.arange(10) / 10
    path = write_ros(tmp_path / "a.bag", {"/a": (time, time[:, None] * [1, 1000])}, {"/a": NUMBERS})
    table = read_table(path, Columns({"/a.data[0]": "readings"}, "/a.log_time"))
    np.testing.assert_allclose(table.values[:, 0], time, atol=1e-9)
    counted = read_table(path, Columns({"/a.data[0]": "readings"}, "/a.data[1]"))  # the clock of the device, ms
    np.testing.assert_array_equal(counted.values[:, 0], 1000 * time)


@pytest.mark.parametrize(
    ("old", "new", "value", "known"),
    [
        ("/pressure.", "/presure.", "/presure.position[0]", "/m/base_1 (geometry_msgs/msg/PointStamped), "),
        ("position[0]", "pressure[0]", "/pressure.pressure[0]", "header.stamp.sec, header.stamp.nanosec"),
        ("position[0]", "position", "/pressure.position", "name[0..0] (text), position[0..0]"),
        ("position[0]", "name[0]", "/pressure.name[0]", "is not a number of /pressure"),
        ("/m/tip_1.header", "/m/tip_4.header", "/m/tip_4.header.stamp", "/pressure (sensor_msgs/msg/JointState)"),
        ("/m/tip_1.header.stamp", "time", "time", "give a topic and a field"),
    ],
)
def test_what_a_bag_has_is_listed(tmp_path, describe, old, new, value, known):
    path = write_ros(tmp_path / "a.bag", series(with_pressure()), KINDS)
    with refused("column", value) as error:
        read_recording(path, describe(text=OF_BAG.replace(old, new)))
    assert known in str(error.value)


def named(*columns: str) -> Columns:
    return Columns(dict.fromkeys(columns, "readings"), columns[0].partition(".")[0] + ".header.stamp")


def two_robots():
    """An arm and a gripper, each with its own joint states on one topic."""
    for i in range(20):
        yield "/arm", 0.01 * i, 0.0, {"shoulder": 1.0, "wrist": 2.0}
        yield "/gripper", 0.01 * i + 0.002, 0.0, {"left": 10.0 + i, "right": 20.0}


def test_an_entry_may_be_given_by_its_name(tmp_path):
    path = write_named(tmp_path / "a.bag", two_robots())
    with collect_notes() as notes:
        found = read_table(path, named("/joints.position[left]"))
    np.testing.assert_array_equal(found.values[:, 1], 10.0 + np.arange(20))
    np.testing.assert_allclose(found.values[:, 0], 0.01 * np.arange(20), atol=1e-9)
    assert [each.subject for each in notes] == ["20 of 40 messages of /joints"]
    both = read_table(path, named("/joints.position[left]", "/joints.position[wrist]"))
    np.testing.assert_array_equal(both.values[:, 1:], np.column_stack((10.0 + np.arange(20), np.full(20, 2.0))))


def test_a_frame_is_given_by_its_child(tmp_path):
    path = write_named(tmp_path / "a.bag", two_robots())
    column = "/tf.transforms[left].transform.translation.x"
    found = read_table(path, Columns({column: "markers"}, "/tf.transforms[left].header.stamp"))
    np.testing.assert_array_equal(found.values[:, 1], 10.0 + np.arange(20))


@pytest.mark.parametrize(
    ("column", "said"),
    [
        ("/joints.position[0]", "'shoulder' in some messages and 'left' in others"),
        ("/tf.transforms[0].transform.translation.x", "'shoulder' in some messages and 'left' in others"),
        ("/joints.position[elbow]", "named are: left, right, shoulder, wrist"),
        ("/joints.header.stamp.sec", "mixed, of '/arm' and '/gripper'"),
    ],
)
def test_a_column_with_several_meanings_is_refused(tmp_path, column, said):
    path = write_named(tmp_path / "a.bag", two_robots())
    with pytest.raises(InputError, match=said):
        read_table(path, Columns({column: "readings"}, "/joints.header.stamp"))


def test_rows_are_sorted_by_a_stamp_that_is_a_little_early(tmp_path):
    rows = [("/a", 0.01 * i - 0.015 * (i == 7), 0.015 * (i == 7), {"x": float(i)}) for i in range(20)]
    with collect_notes() as notes:
        found = read_table(write_named(tmp_path / "a.bag", rows), named("/joints.position[0]"))
    assert (np.diff(found.values[:, 0]) > 0).all()
    assert found.values[:8, 1].tolist() == [0, 1, 2, 3, 4, 5, 7, 6]
    assert [(each.outcome, each.subject) for each in notes] == [("mended", "1 of 20 messages")]


def test_stamps_of_another_recording_are_not_sorted_into_this(tmp_path):
    rows = [("/a", 0.01 * (i % 200), 2.0 * (i >= 200), {"x": float(i)}) for i in range(400)]
    path = write_named(tmp_path / "a.bag", rows)
    assert (np.diff(read_table(path, named("/joints.position[0]")).values[:, 0]) < 0).any()


@pytest.mark.slow
def test_a_file_that_takes_too_much_memory_or_time_is_refused(tmp_path, describe, monkeypatch):
    path = write_json_mcap(tmp_path / "a.mcap", {"/a": (np.zeros(1), np.zeros((1, 1_400_000)))})
    columns = Columns({"/a.position[0]": "readings"}, "/a.header.stamp")
    assert path.stat().st_size < 2e5, "it is compressed"
    assert read_table(path, columns).values.shape == (1, 2)
    monkeypatch.setattr(isolated_reading, "_MAX_MEMORY", 140 << 20)
    with refused("file", "a.mcap"):
        read_table(path, columns)
    monkeypatch.setattr(isolated_reading, "_TIMEOUT", 0.01)
    with refused("file", "a.mcap") as error:
        read_table(path, columns)
    assert "within 0.01 s" in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a.bag", "a.mcap", "a.db3"])
def test_damaged_files_end_in_a_line(tmp_path, describe, monkeypatch, name):
    monkeypatch.setattr(isolated_reading, "_TIMEOUT", 10.0)
    write = FORMATS.get(name) or FORMATS["sqlite"]
    path = write(tmp_path / ("bag" if name == "a.db3" else name), series(with_pressure()), KINDS)
    content = next(path.glob("*.db3")).read_bytes() if path.is_dir() else path.read_bytes()
    for seed in range(6):
        (tmp_path / name).write_bytes(damaged_bytes(content, seed))
        with suppress(InputError):
            assert np.isfinite(read_recording(tmp_path / name, describe(text=OF_BAG)).time).all()
