"""Options that give paths."""

import argparse
from pathlib import Path


def path(text: str) -> Path:
    """The path that an option gives, ~ being the user's home even where no shell has put it in.

    Raises:
        ArgumentTypeError: if it is empty, or of no user.
    """
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError("give a path")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_out_folder(parser: argparse.ArgumentParser, default: Path) -> None:
    """Declares where a command writes its results."""
    parser.add_argument("--out", metavar="DIR", type=path, default=default, help="default: %(default)s")
