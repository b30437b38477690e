"""Claims on the terminal."""

import sys
from collections.abc import Sequence

from soft_gripper.evaluation.paper.claims import Claim, verdict


def print_claims(claims: Sequence[Claim]) -> None:
    """A line for each, with our number, and how many fail."""
    width = max(len(claim.text) for claim in claims)
    print(f"\n{'claim':<{width}}  by     here")
    for claim in claims:
        word = "holds" if claim.holds else _red("FAILS")
        print(f"{claim.text:<{width}}  {claim.source:<6} {word}: {claim.number}")
    summary = verdict(claims)
    print("\n" + (summary if all(claim.holds for claim in claims) else _red(summary)))


def _red(text: str) -> str:
    """Red where somebody looks; a file or a pipe gets plain text."""
    return f"\033[31m{text}\033[0m" if sys.stdout.isatty() else text
