"""Files are written whole or not at all."""

import os
import subprocess

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files import atomic_file, locked, read_folder, writable_folder, write_folder


def test_file_appears_when_the_block_ends(tmp_path):
    path = tmp_path / "out.txt"
    with atomic_file(path) as partial:
        partial.write_text("new")
        assert not path.exists()
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


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
    with pytest.raises(InputError, match="cannot be written") as caught, atomic_file(path) as partial:
        partial.write_text("new")
    assert repr(str(path)) in str(caught.value)


def test_a_folder_in_the_place_of_the_file(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(InputError, match="cannot be written"), atomic_file(folder) as partial:
        partial.write_text("new")
    assert list(tmp_path.iterdir()) == [folder]


def test_folder_is_made_with_its_parents_and_left_empty(tmp_path):
    folder = writable_folder(tmp_path / "a/b")
    assert folder == tmp_path / "a/b"
    assert list(folder.iterdir()) == []
    assert writable_folder(folder) == folder


@pytest.mark.parametrize("inside", ["", "below"])
def test_folder_in_the_place_of_a_file(tmp_path, inside):
    (tmp_path / "a_file").touch()
    with pytest.raises(InputError, match="cannot be written to"):
        writable_folder(tmp_path / "a_file" / inside)


def test_what_a_killed_process_left_of_a_file_is_removed_and_nothing_else(tmp_path):
    with subprocess.Popen(["true"]) as gone:
        pass
    kept = [f".{os.getpid()}-of_one_that_runs.csv", ".hidden", ".git-keep", "1-table.csv"]
    for name in (f".{gone.pid}-table.csv", *kept):
        (tmp_path / name).touch()
    writable_folder(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(kept)


def test_a_folder_is_kept_by_one_process_at_a_time(tmp_path):
    with locked(tmp_path), pytest.raises(InputError, match="another run is writing to it"), locked(tmp_path):
        pass
    with locked(tmp_path):
        assert list(tmp_path.iterdir()) == []


def test_a_folder_is_read_and_written_whole(tmp_path):
    files = {"a.txt": b"1", "b.nc": bytes(range(256))}
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old").touch()
    write_folder(tmp_path / "out", files)
    assert read_folder(tmp_path / "out") == files
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
