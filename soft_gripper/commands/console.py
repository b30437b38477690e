"""The output of a command: text for people, one JSON document for programs, or nothing; and progress bars."""

import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, redirect_stdout
from dataclasses import asdict, dataclass, field
from io import StringIO
from pathlib import Path
from threading import RLock
from typing import Any

from tqdm import tqdm

from soft_gripper.files.row_table import write_csv
from soft_gripper.progress import SIMULATED, run_progress, simulated_seconds

COUNTED = "{desc}: {n_fmt}/{total_fmt}{postfix} [{elapsed}<{remaining}]"
LINE_PERIOD = 15.0  # s, between the lines of progress in a file
tqdm.set_lock(RLock())  # its own serves processes too: Python 3.14 starts `python -c` for it, in the current folder


class _Lines:
    """A file to which tqdm writes lines of progress, in the place of a bar that it draws again and again."""

    def write(self, text: str) -> None:
        if line := text.strip("\r\n "):
            print(line, file=sys.stderr)

    def flush(self) -> None:
        sys.stderr.flush()


@dataclass
class Console:
    """Controls how much a command prints. Tables are always collected; they make up the JSON document."""

    quiet: bool = False
    json: bool = False
    document: dict[str, Any] = field(default_factory=dict)

    def table(self, name: str, rows: Sequence[Any], file: Path | None = None) -> None:
        """Adds a table, given as dataclass rows, to the JSON document, and writes it as a CSV file."""
        if file is not None:
            write_csv(file, rows)
        self.document[name] = [asdict(row) for row in rows]

    def wrote(self, *files: Path) -> None:
        """Lists the files that were written."""
        self.document.setdefault("written", []).extend(str(file) for file in files)
        print("\nWritten: " + ", ".join(map(str, files)))

    def counter(self, total: int | None, description: str) -> "tqdm[None]":
        """A counting progress bar on a terminal; a line every LINE_PERIOD in a file."""
        if sys.stderr.isatty():
            return tqdm(total=total, desc=description, dynamic_ncols=True, disable=self.quiet)
        return self._lines(total, description, COUNTED if total else None)

    def seconds_bar(self, total: float, description: str) -> "tqdm[None]":
        """A progress bar of simulated seconds."""
        if sys.stderr.isatty():
            return simulated_seconds(total, description, disable=self.quiet)
        return self._lines(total, description, f"{{desc}}: {SIMULATED}")

    def _lines(self, total: float | None, description: str, form: str | None) -> "tqdm[None]":
        settings: dict[str, Any] = {"mininterval": LINE_PERIOD, "delay": LINE_PERIOD, "maxinterval": LINE_PERIOD}
        return tqdm(total=total, desc=description, bar_format=form, file=_Lines(), disable=self.quiet, **settings)

    def progress(self, description: str, duration: float) -> AbstractContextManager[Callable[[float], None]]:
        """Shows the progress of a run of `duration` s; pass the yielded function to `simulate`."""
        return run_progress(self.seconds_bar(duration, description))

    @contextmanager
    def speaking(self) -> Iterator[None]:
        """Lets a command print to the terminal, or suppresses its text and prints the JSON document at the end."""
        if not (self.quiet or self.json):
            yield
            return
        with redirect_stdout(StringIO()):
            yield
        if self.json:
            json.dump(_plain(self.document), sys.stdout, indent=2, ensure_ascii=False, allow_nan=False)
            print()


def _plain(value: Any) -> Any:
    """A value as JSON can represent it; None for numbers that are not finite."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, bool | int | str | None) else _plain(value.tolist())
