"""CSV tables: what is written is read again, in plain text that every program opens."""

from dataclasses import dataclass
from typing import Annotated

import pytest
from refusals import refused

from soft_gripper.files.row_table import print_rows, print_table, read_csv, write_csv
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow

NAN = float("nan")
POSES = [
    PoseRow("box_grasp", "left_finger", "arcs", "as simulated", 1, 0.0, 0.0, 0.0, 0.0),
    PoseRow("a, b", 'the "third"', "mine:make", "length +1 %; response", 4, -12.5, 171.123456, 0.000001, 1234.5),
]
FORCES = [ForceRow("free_bending", "finger", "arcs", "as simulated", 2, 150.0, 11, -0.139409, 1e-6)]


@dataclass(frozen=True)
class Number:
    value: float


@pytest.mark.parametrize("rows", [POSES, FORCES, POSES[:1]])
def test_what_is_written_is_read_again(tmp_path, rows):
    write_csv(tmp_path / "table.csv", rows)
    assert read_csv(tmp_path / "table.csv", type(rows[0])) == rows


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1234565001, "0.123457"),
        (-0.0, "0.000000"),
        (-1e-9, "0.000000"),
        (1e9, "1000000000.000000"),
        (2.0, "2.000000"),
    ],
)
def test_numbers_have_six_decimals_and_no_negative_zero(tmp_path, value, text):
    write_csv(tmp_path / "table.csv", [Number(value)])
    assert (tmp_path / "table.csv").read_text() == f"value\n{text}\n"


@pytest.mark.parametrize("text", [None, "", "value\n", "value\nx\n", "other\n1\n", "value\n1\n\udcff"], ids=str)
def test_what_is_no_table_is_named(tmp_path, text):
    path = tmp_path / "table.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with refused("file", "table.csv"):
        read_csv(path, Number)


def test_a_table_that_fails_leaves_the_old_one(tmp_path):
    write_csv(tmp_path / "table.csv", FORCES)
    before = (tmp_path / "table.csv").read_bytes()
    with pytest.raises(TypeError):
        write_csv(tmp_path / "table.csv", [*POSES, "no row"])
    assert (tmp_path / "table.csv").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]


@dataclass(frozen=True)
class Printed:
    finger: str
    tip_error_mm: Annotated[float, ".2f"]
    step: int
    largest_impulse_mns: Annotated[float, ".1f"] = 0.0


def test_a_table_is_printed_under_headings_with_units(capsys):
    print_rows([Printed("left", 1.234, 10, -0.01), Printed("right", 12.5, 9, 3.14)], "Errors", leave=("step",))
    assert capsys.readouterr().out.splitlines() == [
        "",
        "Errors",
        "finger  tip error  largest impulse",
        "             [mm]           [mN s]",
        "left         1.23              0.0",
        "right       12.50              3.1",
    ]


def test_what_is_unknown_is_a_dash_and_a_column_of_nothing_else_is_left_out(capsys):
    print_table({"finger": "", "force [N]": ".1f", "width [mm]": ".1f"}, [["left", 1.0, NAN], ["right", NAN, NAN]])
    assert capsys.readouterr().out.splitlines() == [
        "",
        "finger  force",
        "          [N]",
        "left      1.0",
        "right       -",
    ]


@pytest.mark.parametrize("count", [5, 40])
def test_a_wide_table_has_lower_headings_and_then_further_columns_below(capsys, count):
    titles = [f"a number of many words, {i} [mm]" for i in range(count)]
    print_table({"finger": "", **dict.fromkeys(titles, ".1f")}, [["left", *map(float, range(count))]])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    rows = [line.split() for line in lines if line.startswith("left")]
    assert len(rows) == (1 if count == 5 else 4), "eleven columns of six letters beside the finger"
    assert [float(cell) for row in rows for cell in row[1:]] == [*map(float, range(count))]
