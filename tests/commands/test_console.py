"""What a command says: text, one JSON document, or nothing."""

import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from soft_gripper.commands.console import Console


@dataclass
class Row:
    name: str
    error_mm: float


def test_document_has_tables_and_files_and_null_for_what_is_no_number(capsys):
    console = Console(json=True)
    with console.speaking():
        print("text for people")
        console.table("errors", [Row("a", 0.5), Row("b", float("nan"))])
        console.wrote(Path("out") / "errors.csv")
        console.wrote(Path("out") / "more.csv")
    rows = [{"name": "a", "error_mm": 0.5}, {"name": "b", "error_mm": None}]
    assert json.loads(capsys.readouterr().out) == {"errors": rows, "written": ["out/errors.csv", "out/more.csv"]}


def test_nothing_is_said_by_a_command_that_fails(capsys):
    def fail():
        with Console(json=True).speaking():
            print("half")
            raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        fail()
    assert capsys.readouterr().out == ""


def test_a_bar_is_full_when_a_run_ends_before_its_time(monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    with Console().progress("run", 10.0) as progress:
        progress(1.0)
        progress(3.0)
    assert "3/3 s simulated" in capsys.readouterr().err.splitlines()[-1]
