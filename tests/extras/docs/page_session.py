"""A how-to page as the session of a reader who does what it says, from top to bottom."""

import re
import runpy
import shlex
import sys
from pathlib import Path
from unittest.mock import patch

from command_line import soft_gripper

_ROOT = Path(__file__).parents[3]
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FILE_NAME = re.compile(r"^(?:# |<!-- )([\w.]+\.\w+)(?: -->)?$")


def follow(page: Path) -> None:
    """Writes the files of a page into the current folder, runs its commands and its Python, in their order.

    A block whose first line is a comment with a name is that file. Blocks of Python share their variables. Commands,
    continued after a backslash, are those of `soft-gripper` or run an example in Python. Indented blocks do not run.
    """
    variables = {"__name__": "__main__"}
    for language, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        first, _, rest = text.partition("\n")
        if name := _FILE_NAME.match(first):
            Path(name[1]).write_text(rest, encoding="utf-8")
        elif language == "python":
            exec(compile(text, page.name, "exec"), variables)
        elif language == "sh":
            _run(text)


def _run(commands: str) -> None:
    for command in commands.replace("\\\n", "").splitlines():
        program, *arguments = shlex.split(command, comments=True)
        if program == "python":
            with patch.object(sys, "argv", arguments):
                runpy.run_path(str(_ROOT / arguments[0]), run_name="__main__")
            continue
        assert program == "soft-gripper", f"a command that is not run: {command}"
        outcome = soft_gripper(*arguments)
        assert outcome.code == 0, outcome.err
