"""Pages, notebooks and all texts of the code against the glossary: one term for one thing."""

import ast
import json
import re
from collections.abc import Iterator

from links import ROOT
from test_markup import SHOWN

GLOSSARY = "docs/glossary.md"
ROWS = re.findall(r"^\| ([^|]+) \| [^|]+ \| ([^|]*)\|$", SHOWN[GLOSSARY], re.MULTILINE)[1:]
CODE = [
    path for folder in ("soft_gripper", "studies", "diagrams", "examples") for path in (ROOT / folder).rglob("*.py")
]
SCENARIOS = [*(ROOT / "diagrams").rglob("*.yaml"), *(ROOT / "examples").rglob("*.yaml")]


def avoided_words() -> re.Pattern[str]:
    """Words of the last column, also in the plural and over the end of a line."""
    words = (
        re.escape(word.strip()).replace(r"\ ", r"\s+") for _, cell in ROWS for word in cell.split(",") if cell.strip()
    )
    return re.compile(rf"\b(?:{'|'.join(words)})s?\b", re.IGNORECASE)


def texts() -> Iterator[tuple[str, str]]:
    """Name and text of every page, notebook, scenario, docstring, message, label and help."""
    yield from ((page, text) for page, text in SHOWN.items() if page != GLOSSARY)
    for path in SCENARIOS:
        yield path.name, path.read_text(encoding="utf-8")
    for notebook in (ROOT / "notebooks").glob("*.ipynb"):
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        yield notebook.name, "\n".join("".join(cell["source"]) for cell in cells)
    for path in CODE:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield f"{path.relative_to(ROOT)}:{node.lineno}", node.value


def test_texts_use_the_terms_of_the_glossary() -> None:
    pattern = avoided_words()
    lines = [f"{name}: {match[0]!r}" for name, text in texts() for match in pattern.finditer(text)]
    assert not lines, "\n".join(lines)


def test_every_term_of_the_glossary_is_used() -> None:
    pages = " ".join(text for page, text in SHOWN.items() if page != GLOSSARY).lower()
    assert [term for term, _ in ROWS if not re.search(rf"\b{term}s?\b", pages)] == []


def test_avoided_words_are_recognized() -> None:
    assert avoided_words().findall("its contact  places, Force\nacross, a bend ratio, place [mm] and the forces") == [
        "contact  places",
        "Force\nacross",
        "bend ratio",
        "place [mm",
    ]
