"""What a command says: text for people, one JSON document for programs, or nothing; and progress bars."""

import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import asdict, dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

from tqdm import tqdm

SIMULATED = "{desc} {bar} {n:.0f}/{total:.0f} s simulated [{elapsed}<{remaining}]"


@dataclass
class Console:
    """How much a command says. Its tables are collected in either case, and are all of the JSON document."""

    quiet: bool = False
    json: bool = False
    document: dict[str, Any] = field(default_factory=dict)

    def table(self, name: str, rows: Sequence[Any]) -> None:
        """Adds a table, rows of a dataclass, to what a program reads."""
        self.document[name] = [asdict(row) for row in rows]

    def wrote(self, *files: Path) -> None:
        """Names the files that were written."""
        self.document.setdefault("written", []).extend(str(file) for file in files)
        print("\nWritten: " + ", ".join(map(str, files)))

    def counter(self, total: int | None, of: str) -> "tqdm[None]":
        """A bar that counts, where somebody looks."""
        return tqdm(total=total, desc=of, dynamic_ncols=True, disable=self.quiet or None)

    @contextmanager
    def jobs(self, total: int, of: str, kept: str) -> Iterator[Callable[..., None]]:
        """Counts jobs; give each that ends, with True if it succeeded, to what this yields.

        Ctrl-C says how many have ended, and what is `kept` of them.
        """
        fine: list[bool] = []
        with self.counter(total, of) as bar:

            def ended(succeeded: bool = True) -> None:
                fine.append(succeeded)
                if not all(fine):
                    bar.set_postfix_str(f"{fine.count(False)} failed")
                bar.update()

            try:
                yield ended
            except KeyboardInterrupt:
                bar.close()
                print(f"\n{len(fine)} of {total} {of} ended; {kept}")
                raise

    def seconds(self, total: float, of: str) -> "tqdm[None]":
        """A bar of simulated seconds, where somebody looks."""
        return tqdm(total=total, desc=of, bar_format=SIMULATED, dynamic_ncols=True, disable=self.quiet or None)

    @contextmanager
    def progress(self, of: str, duration: float) -> Iterator[Callable[[float], None]]:
        """Shows how far a run of `duration` s has come; give what it yields to `simulate`."""
        with self.seconds(duration, of) as bar:
            yield lambda time: bar.update(time - bar.n)
            bar.total = bar.n  # a task may be over before its time limit
            bar.refresh()

    @contextmanager
    def speaking(self) -> Iterator[None]:
        """While a command runs: its text goes to the terminal, or nowhere and the document follows."""
        if not (self.quiet or self.json):
            yield
            return
        with redirect_stdout(StringIO()):
            yield
        if self.json:
            json.dump(_plain(self.document), sys.stdout, indent=2, ensure_ascii=False, allow_nan=False)
            print()


def _plain(value: Any) -> Any:
    """What JSON can say of a value; None for what is no finite number."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, bool | int | str | None) else _plain(value.tolist())
