"""What a command declares itself to."""

import argparse
from typing import TypeAlias

Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
PROGRAM = "soft-gripper"


def add_command(subparsers: Subparsers, name: str, does: str, *examples: str) -> argparse.ArgumentParser:
    """Declares a command.

    Args:
        subparsers: where.
        name: of the command.
        does: what, in half a sentence.
        examples: command lines, and behind two spaces or more what they are for.
    """
    return subparsers.add_parser(
        name,
        help=does,
        description=does[0].upper() + does[1:] + ".",
        epilog="\n".join(["examples:", *(f"  {PROGRAM} {name} {example}".rstrip() for example in examples)]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
