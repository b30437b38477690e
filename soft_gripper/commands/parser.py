"""The command line: every command with its options, help and examples.

Nothing here imports Drake or numpy, so that help, completion and usage errors are reported at once. The module of
a command is imported when the command runs. Extras add their commands to those of the core.
"""

import argparse
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any, NoReturn

import shtab

from soft_gripper.commands.options import (
    CONSOLE,
    ENGINE,
    HOST,
    HTML,
    MCAP,
    PROGRAM,
    Command,
    ExitCode,
    Group,
    Option,
    Program,
    flag,
    option,
    path,
    scenario,
    scenario_name,
    urdf,
    whole,
)
from soft_gripper.errors import InputError, shortened, single_line, suggestion
from soft_gripper.extras import command_modules
from soft_gripper.registry import registered
from soft_gripper.scenario.shipped import scenario_names


def _check_run(options: argparse.Namespace) -> None:
    if options.meshcat and not registered("VIEWERS"):
        expected = "no installed extra shows a run in a browser; --html FILE writes an animation"
        raise InputError("run", "--meshcat", True, expected)


CORE = (
    Command(
        "run",
        "run a scenario and record every signal",
        (
            "box_grasp                          write tables and every signal to results/box_grasp",
            "box_grasp --meshcat                watch it in a browser",
            "box_grasp --html animation.html    save a 3-D animation that opens offline",
            "my_scenario.yaml --set sensor.sections=2 --json",
        ),
        (
            *CONSOLE,
            *scenario(),
            ENGINE,
            option(
                "--out",
                "folder for the results (default: results/SCENARIO, or SCENARIO-2 ... if that holds another run)",
                "DIR",
                path,
            ),
            flag("--meshcat", "show the run in a browser, and wait when it ends"),
            HOST,
            HTML,
            option("--video", "write a video: .mp4, .gif, .webp or .png", "FILE", path),
            MCAP,
        ),
        _check_run,
        group=Group.START,
    ),
    Command("list", "list the shipped scenarios", ("--json",), CONSOLE, group=Group.START),
    Command(
        "show",
        "print a resolved scenario, and optionally draw its block diagram",
        ("box_grasp                            print all fields as YAML", "box_grasp --graphviz blocks.svg"),
        (*scenario(), option("--graphviz", "write the block diagram (.dot, .svg, .png or .pdf)", "FILE", path)),
        group=Group.START,
    ),
    Command(
        "expand",
        "expand the <finger>s of a URDF to links, joints and springs",
        ("package://soft_gripper/grippers/two_finger.urdf -o plain.urdf", "mine.urdf --segments 24 -o plain.urdf"),
        (
            option("file", "URDF file, a path or a package://soft_gripper/... URI"),
            option("--segments", "number of segments of each finger (default: as in the file)", "N", whole(1)),
            option("-o --out", "file to write (default: standard output)", "FILE", path),
        ),
        group=Group.DESIGN,
    ),
    Command("doctor", "check the installation", ("", "--json"), CONSOLE, group=Group.START),
)


def commands() -> list[Command]:
    """Returns the commands of the core, then those of extras."""
    return [*CORE, *(command for module in command_modules() for command in module.COMMANDS)]


SOFT_GRIPPER = Program(PROGRAM, "Soft, sensing grippers simulated in Drake.", tuple(Group), commands)


def _columns() -> int:
    """The width of a help text in columns: that of the terminal, at most 100."""
    return min(shutil.get_terminal_size().columns, 100)


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Lays out a help, with room for the names of studies."""

    def __init__(self, prog: str, **settings: Any):
        super().__init__(prog, max_help_position=28, width=_columns(), **settings)


class _Parser(argparse.ArgumentParser):
    """Reports a usage error in one line, and quotes the input shortened, as all other messages do."""

    def __init__(self, program: Program, **settings: Any):
        super().__init__(formatter_class=_Formatter, **settings)
        self._program = program

    def error(self, message: str) -> NoReturn:
        usage_prefix = self.prog.replace(f"{self._program.name} ", f"{self._program.name}: ")
        hint = f"`{self._program.name} COMMAND --help` lists options"
        self.exit(ExitCode.REFUSED, f"{usage_prefix}: {single_line(shortened(message))}; {hint}\n")


class _CommandsParser(_Parser):
    """Lists all commands by the tasks that they are for, in the place of argparse's one list."""

    def format_help(self) -> str:
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, [])
        formatter.add_text(self.description)
        for group in self._program.groups:
            formatter.start_section(group)
            group_commands = [command for command in self._program.commands() if command.group == group]
            formatter.add_arguments([_line(command) for command in group_commands])
            formatter.end_section()
        formatter.start_section("options")
        formatter.add_arguments([action for action in self._actions if action.option_strings])
        formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()


def _line(command: Command) -> argparse.Action:
    """A command in the list of `--help`, as argparse lays out an argument."""
    return argparse.Action([], "", metavar=command.name, help=command.does)


def command_parser(program: Program = SOFT_GRIPPER) -> argparse.ArgumentParser:
    """The parser of all commands; its results hold the Command as `command`, and values as text."""
    codes = ", ".join(f"{code.value} {code.name.lower().replace('_', ' ')}" for code in ExitCode)
    parser = _CommandsParser(
        program,
        prog=program.name,
        description=program.does,
        epilog=f"`{program.name} COMMAND --help` has examples.\nExit codes: {codes}.",
    )
    parser.add_argument("--version", action="version", version=f"{program.name} {version(PROGRAM)}")
    subparsers = {"": parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)}
    for command in program.commands():
        family, _, name = command.name.rpartition(" ")
        if family not in subparsers:
            description = f"Run a {family}: many runs or recordings, their tables, and what they say."
            line = f"run a {family}"
            family_parser = subparsers[""].add_parser(family, program=program, help=line, description=description)
            subparsers[family] = family_parser.add_subparsers(required=True, metavar="NAME", parser_class=_Parser)
        own_name = f"{program.name} {command.name}"
        subparser = subparsers[family].add_parser(
            name,
            program=program,
            help=command.does,
            description=textwrap.fill(f"{command.does[0].upper()}{command.does[1:]}.", _columns()),
            epilog="\n".join(["examples:", *(_example(own_name, example) for example in command.examples)]),
        )
        subparser.set_defaults(command=command)
        for entry in command.options:
            _complete(subparser.add_argument(*entry.names, **entry.settings), entry)
    if program is SOFT_GRIPPER:
        _add_completion(parser)
    return parser


def _example(command: str, example: str) -> str:
    """An example to paste into a shell, below a comment on its effect."""
    line, _, comment = re.sub(r"\s{2,}", "\n", example, count=1).partition("\n")
    words = re.sub(r"'[^']*'", lambda match: match[0].replace(" ", "\0"), f"{command} {line}")
    wrapped = textwrap.wrap(words, _columns() - 8, break_long_words=False, break_on_hyphens=False)
    return (f"  # {comment}\n" if comment else "") + "  " + " \\\n      ".join(wrapped).replace("\0", " ")


_SCENARIO_COMPLETION = "_soft_gripper_scenarios"


def _add_completion(parser: argparse.ArgumentParser) -> None:
    names = " ".join(scenario_names())
    preamble = {
        "bash": f'{_SCENARIO_COMPLETION}() {{ compgen -W "{names}" -- "$1"; compgen -f -- "$1"; }}',
        "zsh": f"{_SCENARIO_COMPLETION}() {{ compadd {names}; _files; }}",
    }
    help_ = "print the shell completion script and exit"
    shtab.add_argument_to(parser, "--print-completion", help=help_, preamble=preamble)


def _complete(action: argparse.Action, option: Option) -> None:
    """Sets how a shell completes an option."""
    if option.read is scenario_name:
        action.complete = {"bash": _SCENARIO_COMPLETION, "zsh": _SCENARIO_COMPLETION}  # type: ignore[attr-defined]
    elif option.read in (path, urdf):
        action.complete = shtab.FILE  # type: ignore[attr-defined]


def parse_options(arguments: Sequence[str] | None = None, program: Program = SOFT_GRIPPER) -> argparse.Namespace:
    """The parsed options of a command line, with the Command as `command`.

    Raises:
        InputError: naming command, option and value, if a value is wrong.
        SystemExit: after --help, and after an error reported by argparse.
    """
    _check_name(sys.argv[1:] if arguments is None else arguments, program)
    options = command_parser(program).parse_args(arguments)
    command: Command = options.command
    for entry in command.options:
        _read_option(options, command, entry)
    command.check(options)
    return options


def _check_name(words: Sequence[str], program: Program) -> None:
    """Names the study, or the nearest command, if the first word is no command."""
    names, first = [command.name for command in program.commands()], next(iter(words), "-")
    if not first.startswith("-") and first not in {name.split()[0] for name in names}:
        raise InputError("command line", "COMMAND", first, suggestion(first, names))


def _read_option(options: argparse.Namespace, command: Command, option: Option) -> None:
    """Replaces the text of an option with its value."""
    name = option.names[-1]
    key = option.settings.get("dest", name.lstrip("-").replace("-", "_"))
    raw = getattr(options, key)
    texts = raw if isinstance(raw, list) else [raw]
    if option.read is None or not all(isinstance(text, str) for text in texts):
        return  # a default
    values = []
    for text in texts:
        try:
            values.append(option.read(text))
        except InputError:
            raise
        except ValueError as error:
            raise InputError(command.name, name, text, str(error)) from None
    setattr(options, key, values if isinstance(raw, list) else values[0])
