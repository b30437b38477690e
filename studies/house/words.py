"""Prints the words of every page of documentation, most first, and their total beside its aim: `make words`."""

import argparse

from studies import ROOT

AIM = 42_000  # words, cells and their borders included, as `wc -w` counts


def word_counts() -> dict[str, int]:
    """Number of words of every page below docs."""
    pages = (ROOT / "docs").rglob("*.md")
    return {page.relative_to(ROOT).as_posix(): len(page.read_text(encoding="utf-8").split()) for page in pages}


def run(options: argparse.Namespace) -> None:
    """Prints the table."""
    counts = word_counts()
    print("| page | words |\n|---|---:|")
    for page, number in sorted(counts.items(), key=lambda item: (-item[1], item[0])):
        print(f"| {page} | {number:,} |")
    print(f"| total, of at most {AIM:,} | {sum(counts.values()):,} |")
