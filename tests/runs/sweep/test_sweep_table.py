"""The table of a sweep: whole whenever it is looked at, and the same however often it was cut short."""

import resource
import subprocess
import sys

import pytest

from soft_gripper.errors import InputError
from soft_gripper.runs.sweep.table import SweepTable, cell

ROWS = {0: ({"k": 0.1}, {"m": 1 / 3}, ""), 1: ({"k": "+10 %"}, {}, 'wrong, "quite"'), 2: ({"k": None}, {"m": -0.0}, "")}
WHOLE = 'run,k,m,error\n0,0.1,0.333333333,\n1,+10 %,,"wrong, ""quite"""\n2,,0,\n'
FULL = """
import resource, sys
from pathlib import Path
from soft_gripper.errors import InputError
from soft_gripper.runs.sweep.table import SweepTable
table = SweepTable(Path(sys.argv[1]), ["k"], ["m"])
table.begin()
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
try:
    for i in range(9):
        table.add(i, {"k": i}, {"m": 0.123456789})
except InputError as error:
    print(error)
"""


@pytest.fixture
def table(tmp_path):
    return SweepTable(tmp_path / "sweep.csv", ["k"], ["m"])


def test_rows_are_there_as_they_come_and_in_order_at_the_end(table, tmp_path):
    table.begin()
    for number in (2, 0, 1):
        table.add(number, *ROWS[number])
        assert len((tmp_path / "sweep.csv").read_text().splitlines()) == 1 + len(table.rows)
    table.finish()
    assert (tmp_path / "sweep.csv").read_text() == WHOLE


@pytest.mark.parametrize("length", range(len(WHOLE) + 1))
def test_a_table_cut_anywhere_comes_to_the_same(table, tmp_path, length):
    table.begin()
    for number in sorted(ROWS):
        table.add(number, *ROWS[number])
    (tmp_path / "sweep.csv").write_text(WHOLE[:length])
    table.resume()
    assert len(table.rows) == max(WHOLE[:length].count("\n") - 1, 0)
    for number in sorted(set(ROWS) - set(table.rows), reverse=True):
        table.add(number, *ROWS[number])
    table.finish()
    assert (tmp_path / "sweep.csv").read_text() == WHOLE


def test_a_table_of_other_columns_is_not_resumed(table, tmp_path):
    (tmp_path / "sweep.csv").write_text("run,other,m,error\n")
    with pytest.raises(InputError, match="has other columns"):
        table.resume()


def test_a_full_disk_is_reported_in_a_line_and_the_table_goes_on(table, tmp_path):
    done = subprocess.run([sys.executable, "-c", FULL, tmp_path / "sweep.csv"], capture_output=True, text=True)
    assert "sweep.csv': cannot be written: File too large\n" in done.stdout
    assert done.stderr == ""
    table.resume()
    assert table.rows[0] == ["0", "0", "0.123456789", ""]
    assert resource.getrlimit(resource.RLIMIT_FSIZE) != (100, 100)


@pytest.mark.parametrize(
    ("value", "text"),
    [(float("nan"), "nan"), (True, "True"), (3, "3"), (1e-7, "1e-07"), (-0.0, "0"), ([1, 2], "[1, 2]")],
)
def test_cells(value, text):
    assert cell(value) == text


def test_rows_are_ordered_by_numbers_not_by_digits(table, tmp_path):
    table.begin()
    for number in reversed(range(12)):
        table.add(number, {"k": number}, {"m": 0.0})
    table.finish()
    found = [line.split(",")[0] for line in (tmp_path / "sweep.csv").read_text().splitlines()[1:]]
    assert found == [str(number) for number in range(12)]
