"""Prints claims, and errors by number of sensors, to the terminal."""

import sys
from collections.abc import Mapping, Sequence

from soft_gripper.extras.paper.claims import Claim, verdict
from soft_gripper.extras.paper.scenario_run import SECTIONS
from soft_gripper.files.row_table import WIDTH, print_table


def print_claims(claims: Sequence[Claim]) -> None:
    """Prints a line for each claim, with our result, and how many claims fail."""
    width, numbers = (max(map(len, texts)) for texts in zip(*((c.text, c.number) for c in claims), strict=True))
    gap = "  " if width + numbers + 16 <= WIDTH else "\n  "  # the number beside the claim, or below it
    print()
    for claim in claims:
        word = "holds" if claim.holds else _red("FAILS")
        text = claim.text if "\n" in gap else f"{claim.text:<{width}}"
        print(f"{text}{gap}{claim.source:<6} {word}: {claim.number}")
    summary = verdict(claims)
    print("\n" + (summary if all(claim.holds for claim in claims) else _red(summary)))


def _red(text: str) -> str:
    """Colours text red on a terminal; a file or a pipe gets plain text."""
    return f"\033[31m{text}\033[0m" if sys.stdout.isatty() else text


def print_sensor_errors(title: str, names: Sequence[str], rows: Mapping[str, Sequence[float]], form: str) -> None:
    """Prints two errors with 1 to 4 sensors per side; rows by name."""
    columns = {"": ""} | {f"{name}, {n}": form for name in names for n in SECTIONS}
    print_table(columns, [(name, *errors) for name, errors in rows.items()], f"{title}, by sensors per side [mm]")
