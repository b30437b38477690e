"""Every option of every command, as declared: what it refuses, in one line that names it, before any work begins."""

import re
import shlex
from contextlib import suppress
from pathlib import Path

import pytest
from refusals import refusal

from soft_gripper.commands import main
from soft_gripper.commands import options as declared
from soft_gripper.commands.options import Command, Option
from soft_gripper.commands.parser import CORE, commands

# By the function that reads an option: texts that it refuses.
REFUSED = {
    declared.whole(0).__qualname__: ("", "many", "1.5", "-5", "²", "100000000000"),
    declared.number(1).__qualname__: ("", "x", "-1", "nan", "1e999"),
    "path": ("", "~no_such_user/x"),
    "mcap_path": ("", "a.nc"),
    "urdf": ("", "a.csv"),
    "assignment": ("sensor.sections", "=3"),
    "scenario_name": ("nowhere.yaml",),
    "scenario_list": ("free_bending,nowhere.yaml",),
}
OUTPUTS = {"-o", "--out", "--html", "--video", "--mcap", "--graphviz"}
ENDINGS = {"--video": ".mp4", "--mcap": ".mcap", "--graphviz": ".svg"}
COMMANDS = {command.name: command for command in commands()}
EVERY_COMMAND = pytest.mark.parametrize("command", COMMANDS.values(), ids=lambda command: command.name)


def options(*names: str) -> list[tuple[Command, Option]]:
    """All options with a value of all commands, or those of some names."""
    every = [(command, option) for command in COMMANDS.values() for option in command.options]
    return [(c, o) for c, o in every if o.names[-1] in names or (not names and o.names[-1].startswith("--"))]


def examples(command: Command) -> list[list[str]]:
    """The examples of a command, without explanations."""
    lines = [re.split(r"(?<=\S)\s{2,}|^\s{2,}", example)[0] for example in command.examples]
    return [[*command.name.split(), *shlex.split(line)] for line in lines]


def files(words: list[str]) -> list[str]:
    """What a line reads from disk, and neither writes nor ships."""
    read = [word for i, word in enumerate(words) if words[i - 1] not in OUTPUTS and not word.startswith("package://")]
    return [word for word in read if word.startswith("~") or Path(word).suffix[1:].isalpha()]


def name_of(case: object) -> str:
    return case.names[-1] if isinstance(case, Option) else getattr(case, "name", "")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a file, and nothing that an example names."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)
    Path("file").write_text("not a folder")


@pytest.mark.parametrize(("command", "option"), options(), ids=name_of)
def test_a_wrong_value_is_refused_with_the_option_and_the_value(command, option, capsys) -> None:
    name, line = option.names[-1], examples(command)[0]
    if option.settings.get("choices"):
        with pytest.raises(SystemExit, match="2"):
            main([*line, name, "nosuch"])
        assert re.match(rf"soft-gripper: {command.name}: .*{name}: invalid choice: 'nosuch' ", capsys.readouterr().err)
    for wrong in REFUSED[option.read.__qualname__] if option.read else ():
        said = refusal(*line, f"{name}={wrong}").removeprefix(f"soft-gripper: {command.name}: ")
        assert said.startswith(f"{name} = {wrong!r}: ")


@EVERY_COMMAND
def test_help_names_every_option_and_one_that_there_is_not_is_refused(command, capsys) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([*command.name.split(), "--help"])
    said = capsys.readouterr().out
    assert [each.names for each in command.options if not all(name in said for name in each.names)] == []
    with pytest.raises(SystemExit, match="2"):
        main([*examples(command)[0], "--frob"])
    said = capsys.readouterr().err
    assert said.startswith("soft-gripper: ")
    assert said.count("\n") == 1


@EVERY_COMMAND
def test_a_file_that_is_missing_is_named(command) -> None:
    words = next(filter(files, examples(command)), None)
    if words is not None:
        line = refusal(*words)
        assert any(Path(file).name in line for file in files(words)), line


@pytest.mark.parametrize(("command", "option"), options(*OUTPUTS), ids=name_of)
def test_what_cannot_be_written_is_refused_before_any_work(command, option) -> None:
    ready = [words for words in examples(command) if not files(words)]
    output = f"file/x{ENDINGS.get(option.names[-1], '.urdf')}"
    if ready and is_read(option, output):
        assert repr(output) in refusal(*max(ready, key=len), option.names[-1], output)


def is_read(option: Option, text: str) -> bool:
    with suppress(ValueError):
        return option.read(text) is not None
    return False


def test_the_least_of_every_whole_number() -> None:
    least: dict[int, set[str]] = {}
    for command in CORE:
        for option in command.options:
            if option.read and option.read.__qualname__ == declared.whole(0).__qualname__:
                texts = [text for text in map(str, range(10)) if is_read(option, text)]
                least.setdefault(int(texts[0]), set()).add(option.names[-1])
    assert least == {1: {"--sections", "--segments"}}
