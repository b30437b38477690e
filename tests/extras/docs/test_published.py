"""Documents print what was written, to the last digit; and how a number that is not would be found.

`make release-check` runs this with the folder of an evaluation.
"""

import os
from pathlib import Path

import pytest
from printed_numbers import differences, sentence_problems, table_problems
from published import ROOT, SENTENCES, TABLES, Written, unguarded

NEEDED = pytest.mark.skipif("EVALUATION" not in os.environ, reason="make release-check")


@pytest.mark.parametrize(
    ("text", "numbers", "is_right"),
    [
        ("0.28", [0.2849], True),
        ("0.28", [0.28505], True),  # another version of Drake may round down
        ("0.28", [0.2852], False),
        ("0.3", [0.2852], True),
        ("-96 and 51.5", [-96.05, 51.522], True),
        ("-96", [96.0], False),
        ("0.00", [-0.001], True),
        ("12", [12.0, 13.0], False),
    ],
)
def test_numbers_are_compared_to_the_digit_that_is_printed(text: str, numbers: list[float], is_right: bool) -> None:
    assert (differences(text, numbers) == []) == is_right


@pytest.mark.parametrize("document", ["README.md", "docs/evaluation.md"])
def test_every_marked_table_is_compared(document: str) -> None:
    assert unguarded(document, (ROOT / document).read_text(encoding="utf-8")) == []


@NEEDED
@pytest.mark.parametrize(("document", "header"), TABLES)
def test_tables_print_what_was_written(document: str, header: str) -> None:
    text = (ROOT / document).read_text(encoding="utf-8")
    expected = TABLES[document, header](Written(Path(os.environ["EVALUATION"])))
    assert table_problems(text, header, expected) == []


@NEEDED
@pytest.mark.parametrize(("document", "pattern"), SENTENCES)
def test_sentences_print_what_was_written(document: str, pattern: str) -> None:
    text = (ROOT / document).read_text(encoding="utf-8")
    expected = SENTENCES[document, pattern](Written(Path(os.environ["EVALUATION"])))
    assert sentence_problems(text, pattern, expected) == []
