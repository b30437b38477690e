"""A study: its jobs, those that fail, and tables that are whole whenever they are looked at."""

import resource
import signal
import subprocess
import sys
from itertools import product

import pytest
from here_executor import HereExecutor

from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.executor import MainScriptError
from soft_gripper.extras.sweeps.study import StudyTables, run_study

ONE = {"a.csv": ["n", "m", "error"]}
TWO = {"a.csv": ["n", "m", "error"], "b.csv": ["n", "x"]}
ROWS = {"0": ["0", "0.333333333", ""], "1": ["1", "", 'wrong, "quite"'], "2": ["2", "0", ""]}
WHOLE = 'n,m,error\n0,0.333333333,\n1,,"wrong, ""quite"""\n2,0,\n'
FULL = """
import resource, sys
from pathlib import Path
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.study import StudyTables
tables = StudyTables(Path(sys.argv[1]), "about", {"a.csv": ["n", "m", "error"]}, 1)
tables.begin("this", False)
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
try:
    for i in range(20):
        tables.add([str(i), "0.123456789", ""])
except InputError as error:
    print(error.field, error.value)
"""


def invert(number: int) -> float:
    if number == 99:
        raise MainScriptError("script", "__main__", "mine.py", "guard it")
    return 1 / number


@pytest.fixture
def ended():
    return []


def study(numbers, ended, failed=None):
    kept = {}
    jobs = {f"job {n}": (n,) for n in numbers}
    run_study(HereExecutor(), invert, jobs, kept.__setitem__, failed, ended.append)
    return kept


def test_what_is_kept_when_ctrl_c_comes_is_counted_too(ended):
    kept, before = {}, signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it

    def keep(key, result):
        signal.raise_signal(signal.SIGINT)
        kept[key] = result

    try:
        with pytest.raises(KeyboardInterrupt):
            run_study(HereExecutor(), invert, {"one": (1,), "two": (2,)}, keep, ended=ended.append)
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(kept) == 1
    assert ended == list(kept)


def test_a_failure_is_raised_when_the_others_have_ended_unless_something_stands_in(ended):
    with pytest.raises(ZeroDivisionError):
        study([0, 1, 2], ended)
    assert sorted(ended) == ["job 0", "job 1", "job 2"]
    kept = study([0, 1], ended, lambda key, error: f"{key}: {error}")
    assert kept == {"job 0": "job 0: ZeroDivisionError: division by zero", "job 1": 1.0}


def test_a_script_that_every_process_would_run_ends_the_study(ended):
    with pytest.raises(MainScriptError):
        study([99], ended, lambda key, error: None)
    assert not ended


def begun(folder, columns, resume=False, about="this"):
    tables = StudyTables(folder, "about", columns, 1)
    tables.begin(about, resume)
    return tables


def filled(folder):
    tables = begun(folder, ONE)
    for row in ROWS.values():
        tables.add(row)
    return tables


@pytest.mark.parametrize("length", range(len(WHOLE) + 1))
def test_a_table_cut_anywhere_comes_to_the_same(tmp_path, length):
    filled(tmp_path)
    (tmp_path / "a.csv").write_text(WHOLE[:length])
    tables = begun(tmp_path, ONE, resume=True)
    assert len(tables.rows) == max(WHOLE[:length].count("\n") - 1, 0)
    for key in sorted(set(ROWS) - {key for (key,) in tables.rows}, reverse=True):
        tables.add(ROWS[key])
    tables.finish([(key,) for key in "012"])
    assert (tmp_path / "a.csv").read_text() == WHOLE


@pytest.mark.parametrize(("first", "second"), list(product(range(4), repeat=2)))
def test_a_row_counts_if_it_is_in_all_tables(tmp_path, first, second):
    tables = begun(tmp_path, TWO)
    for key, row in ROWS.items():
        tables.add(row, [key, f"x{key}"])
    for table, kept in (("a.csv", first), ("b.csv", second)):
        lines = (tmp_path / table).read_text().splitlines(keepends=True)
        (tmp_path / table).write_text("".join(lines[: 1 + kept]))
    assert list(begun(tmp_path, TWO, resume=True).rows) == [(key,) for key in "012"[: min(first, second)]]


def test_a_row_of_either_table_that_was_changed_does_not_count(tmp_path, caplog):
    tables = begun(tmp_path, TWO)
    for key, row in ROWS.items():
        tables.add(row, [key, f"x{key}"])
    (tmp_path / "a.csv").write_text((tmp_path / "a.csv").read_text().replace("0.333333333", "0.433333333"))
    (tmp_path / "b.csv").write_text((tmp_path / "b.csv").read_text().replace("x2", "x3"))
    assert list(begun(tmp_path, TWO, resume=True).rows) == [("1",)]
    assert "2 rows" in caplog.text


def test_another_study_and_other_columns_are_not_resumed(tmp_path):
    filled(tmp_path)
    for arguments in ({"columns": ONE, "about": "other"}, {"columns": {"a.csv": ["n", "other"]}}):
        with pytest.raises(InputError) as error:
            begun(tmp_path, resume=True, **arguments)
        assert error.value.field == "--resume"
    assert (tmp_path / "a.csv").read_text() == WHOLE


def test_a_full_disk_is_reported_and_the_table_goes_on(tmp_path):
    done = subprocess.run([sys.executable, "-c", FULL, tmp_path], capture_output=True, text=True)
    assert done.stdout.startswith(f"file {tmp_path / 'a.csv'}")
    assert done.stderr == ""
    tables = begun(tmp_path, ONE, resume=True)
    assert tables.rows[("0",)] == [["0", "0.123456789", ""]]
    assert resource.getrlimit(resource.RLIMIT_FSIZE) != (100, 100)
