"""Quotes published numbers beside those of the benchmark: other bodies, sensors and contacts, so for scale only."""

from collections.abc import Set
from dataclasses import dataclass
from pathlib import Path

from soft_gripper.files.row_table import read_csv


@dataclass(frozen=True)
class Published:
    """A number that a source states."""

    tasks: str  # of the benchmark that it may be compared with, separated by spaces
    value: str
    what: str
    source: str


def comparable_numbers(tasks: Set[str]) -> list[Published]:
    """Published numbers that may be compared with one of these tasks."""
    numbers = read_csv(Path(__file__).with_name("published.csv"), Published)
    return [number for number in numbers if not tasks.isdisjoint(number.tasks.split())]
