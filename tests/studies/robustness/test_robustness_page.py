"""The page of robustness prints rows of the table beside it."""

import csv
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs/studies/robustness.md"
FIGURES = "sensors_1", "sensors_2", "sensors_4", "covered_percent_2"


def printed_rows() -> list[tuple[str, ...]]:
    """Scenario, estimator and numbers of every row of a table that names an estimator."""
    rows, scenario = [], ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip(" `").replace("–", "-") for cell in line.strip("|").split("|")]
        if len(cells) > 4 and cells[1] in ("arcs", "gaussian", "recursive"):
            scenario = cells[0] or scenario
            rows.append((scenario, *cells[1:]))
    return rows


def test_every_row_of_the_page_is_one_of_the_table():
    with PAGE.with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        table = [
            (row["scenario"], row["estimator"], *(row[name] for name in FIGURES if row[name]))
            for row in csv.DictReader(file)
        ]
    printed = printed_rows()
    assert len(printed) == 10
    assert set(printed) <= set(table)
