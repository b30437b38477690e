"""The command line: what is understood, mistakes, and completion by bash."""

import json
import shlex
import shutil
import subprocess
import sys

import pytest
from command_line import complaint, help_of

from soft_gripper.commands.options import number
from soft_gripper.commands.parser import command_parser, commands, parse_options
from soft_gripper.errors import InputError

NAMES = [command.name for command in commands()]


@pytest.mark.parametrize("command", NAMES)
def test_examples_are_understood_as_they_are_pasted(command):
    text = help_of(command).partition("examples:")[2]
    lines = [line for line in text.replace("\\\n", "").splitlines() if line and not line.startswith("  # ")]
    assert lines
    for line in lines:
        program, *arguments = shlex.split(line)
        assert program == "soft-gripper"
        assert command_parser().parse_args(arguments).command.name == command


@pytest.mark.parametrize("text", ["-1e-9", "-5e-324", "2.1", "1e308", "inf", "nan", "1e999", "", "x"])
def test_no_number_from_zero(text):
    with pytest.raises(ValueError, match="from 0 to 2"):
        number(2.0)(text)


@pytest.mark.parametrize(
    ("line", "field"),
    [
        ("run nowhere", "name"),
        ("frob", "COMMAND"),
        ("run nowhere.yaml", "scenario"),
    ],
)
def test_mistakes_name_the_option(line, field):
    with pytest.raises(InputError) as error:
        parse_options(line.split())
    assert error.value.field == field


def test_a_view_that_no_extra_shows_is_refused(monkeypatch):
    monkeypatch.setattr("soft_gripper.commands.parser.registered", lambda kind: {})
    with pytest.raises(InputError, match="no installed extra shows a run in a browser"):
        parse_options(["run", "box_grasp", "--meshcat"])


def test_a_wrong_command_is_answered_with_the_right_one():
    with pytest.raises(InputError, match="did you mean 'expand'"):
        parse_options(["expnd", "a.urdf"])


BY_ARGPARSE = ["", "run", "run box_grasp --frob", "run box_grasp --out"]


@pytest.mark.parametrize("line", [*BY_ARGPARSE, f"run --{'y' * 50_000} \x1b[2J"], ids=lambda line: line[:20])
def test_mistakes_that_argparse_finds_are_one_line(line):
    said = complaint(line)
    assert len(said) < 2000
    assert "\x1b" not in said


QUICK = [
    ["--help"],
    ["--version"],
    ["--print-completion", "bash"],
    ["list"],
    ["list", "--json"],
    *([*name.split(), "--help"] for name in NAMES),
    [],
    ["frob"],
    ["run", "nowhere"],
    ["run", "nowhere.yaml"],
    ["expand", "a.urdf", "--segments", "0"],
]
RUN_ALL = """
import contextlib, io, json, sys
from soft_gripper.commands import main
for arguments in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        with contextlib.suppress(SystemExit):
            main(arguments)
    heavy = {"pydrake", "numpy", "scipy", "matplotlib", "xarray"} & set(sys.modules)
    if heavy:
        sys.exit(f"{arguments} imports {heavy}")
"""


def test_help_lists_and_mistakes_import_neither_drake_nor_numpy():
    done = subprocess.run(
        [sys.executable, "-c", RUN_ALL, json.dumps(QUICK)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


BASH = shutil.which("bash")


def completed(script, *words):
    line = " ".join(f"'{word}'" for word in words)
    ask = f"COMP_WORDS=(soft-gripper {line}); COMP_CWORD={len(words)}; _shtab_soft_gripper"
    lines = [script, ask, 'printf "%s\\n" "${COMPREPLY[@]}"']
    return set(
        subprocess.run([BASH, "-c", "\n".join(lines)], capture_output=True, text=True, check=True).stdout.split()
    )


@pytest.mark.skipif(BASH is None, reason="needs bash")
def test_bash_completes_commands_scenarios_options_and_files(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("own.yaml", "own_results"):
        (tmp_path / name).touch()
    with pytest.raises(SystemExit):
        command_parser().parse_args(["--print-completion", "bash"])
    script = capsys.readouterr().out
    assert completed(script, "ex") >= {"expand"}
    assert "box_grasp" in completed(script, "run", "box")
    assert completed(script, "run", "--mesh") == {"--meshcat"}
    assert completed(script, "run", "own") == {"own.yaml", "own_results"}
    assert completed(script, "run", "--out", "own_") == {"own_results"}
