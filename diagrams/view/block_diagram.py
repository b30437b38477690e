"""The block diagram of a Drake diagram, as Graphviz text or as a picture."""

import re
from itertools import groupby
from pathlib import Path

from pydrake.systems.framework import Diagram

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file

_SYSTEM_NUMBER = re.compile(r"\b(s|clusters?|_)(\d+)(?=[a-z:\s])")
PICTURES = (".svg", ".png", ".pdf")


def graphviz(diagram: Diagram, max_depth: int = 1) -> str:
    """Graphviz (DOT) text; `max_depth` is the number of levels of sub-diagrams that are expanded.

    Drake numbers systems per process, and lists wires by memory address. Here the same diagram gives the same text in
    every run: systems are numbered in order, and wires are sorted.
    """
    numbers: dict[str, str] = {}
    drawn: str = diagram.GetGraphvizString(max_depth=max_depth)
    text = _SYSTEM_NUMBER.sub(lambda match: match[1] + numbers.setdefault(match[2], str(len(numbers))), drawn)
    blocks = groupby(text.splitlines(), lambda line: " -> " in line)
    return "\n".join(line for wires, lines in blocks for line in (sorted(lines) if wires else lines)) + "\n"


def save_block_diagram(diagram: Diagram, path: Path) -> None:
    """Writes DOT text, or a picture if the name ends in .svg, .png or .pdf.

    Raises:
        InputError: if the name has another ending, or a picture is requested and pygraphviz is not installed.
    """
    text = graphviz(diagram)
    if path.suffix in (".dot", ".gv"):
        with atomic_file(path) as partial:
            partial.write_text(text, encoding="utf-8")
        return
    if path.suffix not in PICTURES:
        raise InputError("--graphviz", "FILE", str(path), f"give a name that ends in .dot, .gv, {', '.join(PICTURES)}")
    try:
        import pygraphviz
    except ImportError:
        expected = "a picture requires pygraphviz: pip install 'soft-gripper[notebooks]'; or name a .dot file"
        raise InputError("--graphviz", "FILE", str(path), expected) from None
    picture = pygraphviz.AGraph(string=text).draw(prog="dot", format=path.suffix[1:])
    with atomic_file(path) as partial:
        partial.write_bytes(picture)
