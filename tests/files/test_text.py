"""What cannot be read is named, and nothing is waited for."""

import os

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_text


def test_text_with_and_without_a_mark(tmp_path):
    for name, mark in (("plain", b""), ("marked", b"\xef\xbb\xbf")):
        (tmp_path / name).write_bytes(mark + "ü\n".encode())
        assert read_text(tmp_path / name) == "ü\n"


def test_what_cannot_be_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    reasons = {
        "pipe": "not a regular file",
        "folder": "not a regular file",
        "loop": "symbolic links",
        "binary": "not a text file",
        "none": "No such file",
        "x" * 300: "too long",
        "a\0b": "null",
    }
    for name, reason in reasons.items():
        with pytest.raises(InputError, match=reason):
            read_text(tmp_path / name)
