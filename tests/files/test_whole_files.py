"""Files are written whole or not at all."""

import os
import stat
import subprocess
from pathlib import Path

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.files import output as files
from soft_gripper.files.output import (
    atomic_file,
    atomic_folder,
    check_file,
    is_whole,
    read_folder,
    writable_folder,
    write_folder,
)


def write_half(path, interruption):
    with atomic_file(path) as partial:
        partial.write_text("half")
        raise interruption


@pytest.mark.parametrize("interruption", [ValueError, KeyboardInterrupt])
def test_interrupted_writing_leaves_the_old_file_and_nothing_else(tmp_path, interruption):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with pytest.raises(interruption):
        write_half(path, interruption)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("place", ["missing", "a_file"])
def test_place_that_cannot_hold_a_file(tmp_path, place):
    (tmp_path / "a_file").touch()
    path = tmp_path / place / "out.txt"
    with refused("file") as caught, atomic_file(path) as partial:
        partial.write_text("new")
    assert repr(str(path)) in str(caught.value)


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="cannot be written: it is not a regular file"):
        check_file(tmp_path / "pipe")
    with pytest.raises(InputError, match="cannot be written: it is not a regular file"), atomic_file(tmp_path / "pipe"):
        pass
    assert stat.S_ISFIFO((tmp_path / "pipe").lstat().st_mode)


def test_a_device_is_written_to():
    check_file(Path("/dev/null"))
    with atomic_file(Path("/dev/null")) as partial:
        partial.write_bytes(b"new")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.parametrize("exists", [True, False])
def test_a_symlink_is_followed(tmp_path, exists):
    (tmp_path / "folder").mkdir()
    target, link = tmp_path / "folder" / "target.dat", tmp_path / "link.txt"
    link.symlink_to(target)
    if exists:
        target.write_text("old")
    with atomic_file(link) as partial:
        assert partial.suffix == ".txt"
        partial.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert list((tmp_path / "folder").iterdir()) == [target]


def test_what_cannot_be_a_file(tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "a_file").touch()
    for name in ("loop", "", ".", "a_file/below", "x" * 300, "a\0b"):
        with refused("file"):
            check_file(tmp_path / name)
    with refused("file"), atomic_file(tmp_path / "loop") as partial:
        partial.write_text("new")
    assert (tmp_path / "loop").is_symlink()


def test_folder_is_whole_while_nothing_in_it_changes(tmp_path):
    folder = tmp_path / "a"
    with atomic_folder(folder) as partial:
        (partial / "one.txt").write_text("1")
        (partial / "below").mkdir()
        (partial / "below" / "two.txt").write_text("2")
    assert is_whole(folder)
    assert subprocess.run(["sha256sum", "-c", "SHA256SUMS"], cwd=folder, capture_output=True).returncode == 0
    (folder / "below" / "two.txt").write_text("")
    assert not is_whole(folder)
    (folder / "below" / "two.txt").unlink()
    assert not is_whole(folder)
    assert not is_whole(tmp_path / "none")


@pytest.fixture
def gone() -> int:
    """The number of a process that has ended."""
    with subprocess.Popen(["true"]) as process:
        pass
    return process.pid


def left_by(pid: int, path: Path, host: str = files._HOST_NAME) -> Path:
    """What a process that was killed left of writing `path`."""
    return path.with_name(f".soft-gripper-{host}-{pid}-{path.name}")


def test_the_names_of_what_killed_processes_leave(tmp_path):
    with atomic_file(tmp_path / "a.csv") as partial:
        assert partial == left_by(os.getpid(), tmp_path / "a.csv")
        partial.touch()
    with atomic_folder(tmp_path / "a") as partial:
        assert partial == left_by(os.getpid(), tmp_path / "a")


def test_what_killed_processes_left_of_files_is_removed_and_nothing_else(tmp_path, gone):
    table = tmp_path / "table.csv"
    left_by(gone, table).touch()
    for name in (f".{gone}-mine.csv", ".hidden", ".git-keep", "1-table.csv", ".soft-gripper-", ".soft-gripper-x.csv"):
        (tmp_path / name).touch()
    left_by(os.getpid(), table).touch()
    left_by(gone, table, "elsewhere").touch()
    left_by(gone, tmp_path / "folder").mkdir()
    (left_by(gone, tmp_path / "folder") / "file").touch()
    left_by(gone, tmp_path / "link").symlink_to(tmp_path / "1-table.csv")
    (tmp_path / f".{gone}-folder").mkdir()
    before = set(tmp_path.rglob("*"))
    writable_folder(tmp_path)
    assert before - set(tmp_path.rglob("*")) == {left_by(gone, table)}


def test_what_a_killed_process_left_of_a_folder_is_removed_and_nothing_else(tmp_path, gone):
    for path in (tmp_path / "a", tmp_path / "b"):
        left_by(gone, path).mkdir()
        (left_by(gone, path) / "half").touch()
    (tmp_path / ".partial-a").mkdir()
    left_by(gone, tmp_path / "a", "elsewhere").mkdir()
    before = set(tmp_path.iterdir())
    write_folder(tmp_path / "a", {"1": b"1"})
    assert before ^ set(tmp_path.iterdir()) == {left_by(gone, tmp_path / "a"), tmp_path / "a"}


def test_a_link_in_the_place_of_what_was_left_of_a_folder(tmp_path, gone):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").touch()
    left_by(gone, tmp_path / "a").symlink_to(tmp_path / "mine")
    write_folder(tmp_path / "a", {"1": b"1"})
    assert (tmp_path / "mine" / "file").exists()


def test_a_folder_that_is_there_keeps_other_files(tmp_path):
    write_folder(tmp_path / "a", {"1": b"old", "2": b"old"})
    (tmp_path / "a" / "below").mkdir()
    (tmp_path / "a" / "below" / "note").write_text("mine")
    write_folder(tmp_path / "a", {"1": b"new"})
    assert (tmp_path / "a" / "below" / "note").read_text() == "mine"
    assert (tmp_path / "a" / "1").read_text() == "new"
    assert is_whole(tmp_path / "a")


def test_a_folder_that_is_replaced_in_part_is_not_whole(tmp_path):
    write_folder(tmp_path / "a", {"1": b"old", "2": b"old"})
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "2").mkdir()  # where a file is to be
    write_folder(tmp_path / "b", {"1": b"old"})
    with pytest.raises(InputError) as error:
        write_folder(tmp_path / "b", {"1": b"new", "2": b"new"})
    assert error.value.value == str(tmp_path / "b")
    assert not is_whole(tmp_path / "b")
    assert {path.name for path in tmp_path.iterdir()} == {"a", "b"}


@pytest.mark.parametrize(
    "name", ["x" * 251 + ".csv", "ä" * 120 + ".csv", os.fsdecode(b"\xff" * 251 + b".csv"), "a\nb.csv"]
)
def test_every_name_that_a_file_may_have(tmp_path, name):
    check_file(tmp_path / name)
    with atomic_file(tmp_path / name) as partial:
        assert partial.suffix == ".csv"
        partial.touch()
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_folder_is_read_and_written_whole(tmp_path):
    contents = {"a.txt": b"1", "b.nc": bytes(range(256))}
    write_folder(tmp_path / "out", contents)
    assert {name: read_folder(tmp_path / "out")[name] for name in contents} == contents
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
