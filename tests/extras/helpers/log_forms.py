"""One log in the forms of loggers, spreadsheets and scripts, and in forms of other programs that are not read."""

from collections.abc import Callable, Mapping
from datetime import datetime, timedelta
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array


class Content(NamedTuple):
    """The names of the columns, the time first, and the numbers as texts."""

    names: list[str]
    rows: list[list[str]]


class Written(NamedTuple):
    """A file, lines that its description needs more, and whether it is read with a note."""

    content: bytes
    more: str = ""
    noted: bool = False


def table(columns: Mapping[str, Array]) -> Content:
    """The content of columns."""
    rows = np.column_stack(list(columns.values()))
    return Content(list(columns), [[f"{value:.6g}" for value in row] for row in rows])


def joined(content: Content, separator: str = ",", decimal: str = ".") -> str:
    """Lines of cells."""
    lines = [content.names, *([cell.replace(".", decimal) for cell in row] for row in content.rows)]
    return "\n".join(map(separator.join, lines)) + "\n"


def _timed(content: Content, form: Callable[[float], str]) -> str:
    return joined(Content(content.names, [[form(float(row[0])), *row[1:]] for row in content.rows]))


def _clock(form: str, begin: str = "2026-11-25T08:00:00") -> Callable[[Content], Written]:
    def write(content: Content) -> Written:
        first = datetime.fromisoformat(begin)
        text = _timed(
            content, lambda t: (first + timedelta(seconds=t)).strftime(form)[: -3 if form[-1] == "f" else None]
        )
        return Written(text.encode(), noted="T23" in begin and "%d" not in form)

    return write


def _with(separator: str, decimal: str = ".", encoding: str = "utf-8") -> Callable[[Content], Written]:
    return lambda content: Written(joined(content, separator, decimal).encode(encoding))


def _changed(change: Callable[[str], str], noted: bool = False, more: str = "") -> Callable[[Content], Written]:
    return lambda content: Written(change(joined(content)).encode(), more, noted)


def _quoted(text: str, separator: str = ",") -> str:
    return "\n".join(",".join(f'"{cell}"' for cell in line.split(separator)) for line in text.splitlines())


def _without_names(content: Content) -> Written:
    return Written(joined(content).partition("\n")[2].encode(), f"header: [{', '.join(content.names)}]")


def _nanoseconds(unit: str, factor: float) -> Callable[[Content], Written]:
    return lambda content: Written(_timed(content, lambda t: f"{round(t * factor)}").encode(), f"time_unit: {unit}")


FORMS: dict[str, Callable[[Content], Written]] = {
    "plain": _with(","),
    "semicolons": _with(";"),
    "semicolons and decimal commas": _with(";", ","),
    "tabs": _with("\t"),
    "tabs and decimal commas": _with("\t", ","),
    "spaces": _with(" "),
    "several spaces": _with("   "),
    "bars": _with(" | "),
    "spaces after commas": _with(", "),
    "a byte order mark": _with(",", encoding="utf-8-sig"),
    "UTF-16": _with("\t", encoding="utf-16"),
    "UTF-16 without a mark": _with(",", encoding="utf-16-le"),
    "Latin-1": lambda content: Written("Meßplatz\n".encode("latin-1") + joined(content).encode(), noted=True),
    "newlines of Windows": _changed(lambda text: text.replace("\n", "\r\n")),
    "newlines of old systems": _changed(lambda text: text.replace("\n", "\r")),
    "no newline at the end": _changed(str.rstrip),
    "empty lines": _changed(lambda text: text.replace("\n", "\n\n")),
    "quotes": _changed(_quoted),
    "decimal commas in quotes": lambda content: Written(
        "\n".join(
            ",".join(f'"{cell}"'.replace(".", ",") for cell in row) for row in [content.names, *content.rows]
        ).encode()
    ),
    "a separator at the end": _changed(lambda text: text.replace("\n", ",\n")),
    "comments": _changed(lambda text: f"# logger 2\n% of monday\n{text}", noted=True),
    "comments between": _changed(lambda text: text.replace("\n", "\n# here\n", 3), noted=True),
    "names in a comment": _changed(lambda text: f"# {text}"),
    "lines before": _changed(lambda text: f"Logger,v2\nDate,2026-11-25\n\n{text}", noted=True),
    "the line of a spreadsheet": lambda content: Written(("sep=;\n" + joined(content, ";")).encode(), noted=True),
    "units below the names": lambda content: Written(
        joined(content).replace("\n", "\n" + ",".join(["s", *["mm"] * (len(content.names) - 1)]) + "\n", 1).encode(),
        noted=True,
    ),
    "zeros at the end": _changed(lambda text: text + 100 * "\0", noted=True),
    "an index": lambda content: Written(
        joined(Content(["", *content.names], [[str(i), *row] for i, row in enumerate(content.rows)])).encode()
    ),
    "no names": _without_names,
    "other names": lambda content: Written(
        joined(content).replace("tip", "top").encode(), f"header: [{', '.join(content.names)}]", True
    ),
    "milliseconds": _nanoseconds("ms", 1e3),
    "microseconds": _nanoseconds("us", 1e6),
    "nanoseconds": _nanoseconds("ns", 1e9),
    "times of day": _clock("%H:%M:%S.%f"),
    "times of day with a comma": lambda content: Written(
        _timed(content, lambda t: f"08:00:{t:06.3f}").replace(",", ";").replace(".", ",").encode()
    ),
    "minutes and seconds": lambda content: Written(_timed(content, lambda t: f"12:{t:06.3f}").encode()),
    "midnight": _clock("%H:%M:%S.%f", "2026-11-25T23:59:59.600000"),
    "ISO 8601": _clock("%Y-%m-%dT%H:%M:%S.%f"),
    "ISO 8601 with a zone": lambda content: Written(
        _timed(content, lambda t: f"2026-11-25T08:00:{t:06.3f}+01:00").encode()
    ),
    "ISO 8601 with a space": _clock("%Y-%m-%d %H:%M:%S.%f"),
    "dates with points": _clock("%d.%m.%Y %H:%M:%S.%f", "2026-11-05T23:59:59.600000"),
    "dates with slashes": _clock("%m/%d/%Y %H:%M:%S.%f", "2026-11-05T23:59:59.600000"),
    "a percent sign before the time": _changed(lambda text: f"%{text}"),
    "padded with blanks": _changed(lambda text: text.replace("\n", " " * 2000 + "\n")),
    "other columns": _changed(lambda text: text.replace("\n", ",OK,1.2.3\n").replace("OK,1.2.3", "state,state", 1)),
    "missing values": _changed(lambda text: text.replace("\n", ",#N/A\n").replace("#N/A", "other", 1)),
}


def drawn(content: Content, seed: int) -> Written:
    """The log in a form whose parts are drawn at random."""
    random = np.random.default_rng(seed)
    separator = str(random.choice([",", ";", "\t", "|", "  "]))
    decimal = "." if separator == "," else str(random.choice([".", ","]))
    text = joined(content, separator, decimal)
    if separator != "  " and random.random() < 0.3:
        text = "\n".join(separator.join(f'"{cell}"' for cell in line.split(separator)) for line in text.splitlines())
    before = int(random.integers(0, 4))
    mark = str(random.choice(["", "# ", "% ", "// "]))
    text = "".join(f"{mark}logger {i}, serial 12; 2026\n" for i in range(before)) + text
    if mark == "# " and '"' not in text:
        text = text.replace(content.names[0], mark + content.names[0], 1)
    newline = str(random.choice(["\n", "\r\n", "\r"]))
    encoding = str(random.choice(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"]))
    return Written(text.replace("\n", newline).encode(encoding), noted=before > 0)
