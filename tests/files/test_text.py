"""What cannot be read is named, and nothing is waited for."""

import os

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_bytes, read_text


def test_what_cannot_be_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "pointer").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 5\n")
    with (tmp_path / "sparse").open("wb") as file:
        file.truncate(10**12)
    reasons = {
        "pipe": "not a regular file",
        "folder": "not a regular file",
        "loop": "symbolic links",
        "binary": "not a text file",
        "pointer": "is a pointer of Git LFS: git lfs pull",
        "sparse": "size = 1000000000000: give a file of at most 33554432 bytes",
        "/dev/zero": "not a regular file",
        "none": "No such file",
        "x" * 300: "too long",
        "a\0b": "null",
    }
    for name, reason in reasons.items():
        with pytest.raises(InputError, match=reason):
            read_text(tmp_path / name)


def test_file_that_grows_while_it_is_read(tmp_path, monkeypatch):
    """As files of /proc, whose size is 0 whatever they hold."""
    (tmp_path / "a").write_bytes(b"x" * 100)
    monkeypatch.setattr(os, "stat", lambda path: os.stat_result([0o100644, *[0] * 9]))
    with pytest.raises(InputError, match="size = 11: give a file of at most 10 bytes"):
        read_bytes(tmp_path / "a", max_bytes=10)


def test_a_file_that_waits_for_data(tmp_path, monkeypatch):
    """Some of /proc are regular, and a read of them waits; here a pipe is said to be regular."""
    os.mkfifo(tmp_path / "log")
    writer = os.open(tmp_path / "log", os.O_RDWR)
    monkeypatch.setattr(os.path, "isfile", lambda path: True)
    with pytest.raises(InputError, match="it waits for what others write"):
        read_bytes(tmp_path / "log")
    os.close(writer)
