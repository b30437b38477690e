"""Cells of tables: which are numbers, which are held, and how long any of them may take."""

import json
import time
from contextlib import suppress

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recording_schema import TextConfig
from soft_gripper.extras.hardware.recordings import read_recordings
from soft_gripper.extras.hardware.table import Columns, drop_zero_stamps
from soft_gripper.extras.hardware.table_files import read_table
from soft_gripper.files.notes import collect_notes

AB = Columns({"a": "readings", "b": "readings"}, "t")


def table(folder, text, columns=AB, name="log.csv"):
    (folder / name).write_text(text)
    with collect_notes() as notes:
        found = read_table(folder / name, columns)
    return found.values, [f"{note.subject}: {note.why}" for note in notes]


@pytest.mark.parametrize("name", ["t", "%t"])
def test_a_first_name_with_a_percent_sign(tmp_path, name):
    values, notes = table(tmp_path, "%t,a,b\n0,1,2\n1,3,4\n", Columns(AB.names, name))
    assert values.tolist() == [[0, 1, 2], [1, 3, 4]]
    assert not notes


@pytest.mark.parametrize(
    ("cell", "other", "value"),
    [
        *(("2 036,00", "12,5", 2036), ("2\xa0036,50", "1\xa0000", 2036.5), ("2\u202f036", "0,5", 2036)),
        *(("2\u2009036.5", "1", 2036.5), ("2'036.00", "1'000", 2036), ("-2\u2019036", "1", -2036)),
        *(
            ("2.036,00", "1.000", 2036),
            ("2,036.00", "1,000", 2036),
            ("1.234", "2.345", 1.234),
            ("1 234 567,8", "0,1", 1234567.8),
        ),
        *(("1,234,567", "0", 1234567), ("1.234", "1,2", None), ("2,036", "0.5", None)),
    ],
)
def test_thousands(tmp_path, cell, other, value):
    """A number with thousands is read where it has one meaning alone; else the description has to say it."""
    text = f"t;a;b\n0;{cell};{other}\n1;{cell};{other}\n"
    if value is not None:
        values, _ = table(tmp_path, text)
        assert values[:, 1].tolist() == [value, value]
        return
    with refused("text.decimal", cell):
        table(tmp_path, text)
    for decimal in ".,":
        if other.replace(decimal, "").isdecimal():
            values, _ = table(tmp_path, text, Columns(AB.names, "t", text=TextConfig(decimal=decimal)))
            assert values[0, 1] == float(
                cell.replace(decimal, "D").replace("," if decimal == "." else ".", "").replace("D", ".")
            )


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        *(("0 kPa", "leave units out of the cells"), ("12.5\xb0", "leave units out"), ("30mm", "leave units out")),
        *(
            ("2 036", "one number or several"),
            ("1_0", "not a number"),
            ("1\u0663", "not a number"),
            ("0x10", "not a number"),
        ),
    ],
)
def test_a_cell_that_is_no_number_is_shown(tmp_path, cell, said):
    with pytest.raises(InputError, match=f"'{cell}' for b, which is .*{said}"):
        table(tmp_path, "t,a,b\n" + f"0,1,{cell}\n" * 30)
    with pytest.raises(InputError, match="only 0 of 1 rows"):
        table(tmp_path, json.dumps({"t": 0, "a": 1, "b": cell}), name="log.jsonl")


@pytest.mark.parametrize("cell", ["", "-nan", "nan(ind)", "N/A", "#VALUE!", "1.#IND"])
def test_missing_cells_are_counted(tmp_path, cell):
    values, notes = table(tmp_path, f"t,a,b\n0,1,{cell}\n1,,{cell}\n2,3,4\n")
    assert np.isnan(values[:2, 2]).all()
    assert notes == ["1 of 3 cells of a: no value there", "2 of 3 cells of b: no value there"]


RATES = "t,a,b,other\n0,1,,\n0.01,,,5\n0.02,,7,\n0.1,2,,\n0.2,3,,\n0.22,,8,\n"


def test_signals_with_rates_of_their_own_are_held(tmp_path):
    """Rows before all have begun are left out, and those without any value."""
    held = Columns(AB.names, "t", hold=0.1)
    values, notes = table(tmp_path, RATES, held)
    nan = np.nan
    np.testing.assert_array_equal(values, [[0.02, 1, 7], [0.1, 2, 7], [0.2, 3, nan], [0.22, 3, 8]])
    assert notes == [
        "1 of 5 rows: some signals began after them",
        "1 of 4 cells of b: no value there, nor in the 0.1 s before (`hold`)",
    ]
    values, _ = table(tmp_path, RATES, Columns(AB.names, "t", time_unit=1e-3, hold=1e-4))
    np.testing.assert_array_equal(values[2], [0.2, 3, nan])
    values, _ = table(tmp_path, "t,a,b\n0,1,1\n5,,2\n0,,3\n", Columns(AB.names, "t", hold=10.0))
    np.testing.assert_array_equal(values[2], [0, nan, 3])  # time began anew: another run
    together = "t,a,b\n0,1,\n0,,2\n1,3,\n1,,4\n2,5,\n2,6,\n2,,7\n"  # a row for each message, at one time
    values, _ = table(tmp_path, together, Columns(AB.names, "t", hold=10.0))
    np.testing.assert_array_equal(values, [[0, 1, 2], [1, 3, 4], [2, 5, 4], [2, 6, 4], [2, 6, 7]])
    values, notes = table(tmp_path, RATES)
    assert len(values) == 6
    assert notes[1] == "4 of 6 cells of b: no value there"


def test_a_table_without_a_value_is_refused(tmp_path, describe):
    (tmp_path / "a.csv").write_text("t,a\n0,\n1,\n")
    described = "time: t\nreadings: [a]\nframe: {origin: [0, 0, 0]}\nhold: 0.1\n"
    for more in ("", "pause: 10\n"):
        with refused("t", 0):
            read_recordings(tmp_path / "a.csv", describe(text=described + more))


def test_times_of_zero_before_a_clock_is_set_are_left_out(tmp_path):
    columns = Columns({"a": "readings"}, "t")
    for before, unit in ((3, 1.0), (1, 1e-3)):
        rows = "".join(f"{t},{i}\n" for i, t in enumerate([0] * before + [(1.6e9 + 0.01 * i) / unit for i in range(9)]))
        (tmp_path / "a.csv").write_text("t,a\n" + rows)
        with collect_notes() as notes:
            found = drop_zero_stamps(read_table(tmp_path / "a.csv", columns), "t", unit)
        np.testing.assert_allclose(unit * found.values[:, 0], 0.01 * np.arange(9), atol=1e-6)
        assert found.values[0, 1] == before
        assert [note.subject for note in notes] == [f"{before} of {before + 9} rows"]
    fails_later = [0, 1.6e9, 1.6e9 + 0.01, 0, 1.6e9 + 0.03]
    for times in ([0, 1, 2], [0, 100, 200], [0, 0, 0], [0], [1, 2], fails_later):
        (tmp_path / "a.csv").write_text("t,a\n" + "".join(f"{t},1\n" for t in times))
        found = read_table(tmp_path / "a.csv", columns)
        assert drop_zero_stamps(found, "t", 1.0) is found


NINES = "9" * 10**6
LONG = {
    "blanks": "t,a,b\n" + 500 * ("0,1,2" + 2000 * " " + "\n"),
    "a line of blanks": "t,a,b\n" + 10**7 * " " + "\n0,1,2\n",
    "blanks before a comment": "t,a,b\n" + 10**6 * " " + "#\n0,1,2\n",
    "digits": f"t,a,b\n0,1,{NINES}x\n1,{NINES}:{NINES},2\n",
    "a clock of digits": f"t,a,b\n{NINES}:{NINES}:00,1,2\n" + "00:00:01,1,2\n" * 9,
    "a clock that is none": "t,a,b\n" + "".join(f"Mon Jan 3 12:00:00 2022 at {i},1,2\n" for i in range(30000)),
    "thousands": "t;a;b\n0;1" + ",000" * 10**5 + "x;0\n1;2;3\n",
    "columns": "t,a,b" + 10**6 * ",c" + "\n0,1,2" + 10**6 * "," + "\n",
    "other columns": ",".join(f"some{i}" for i in range(10**5)) + "\n",
    "empty lines": "t,a,b\n" + 10**6 * "\n" + "0,1,2\n",
    "marks of comments": "t,a,b\n" + 10**6 * "#" + "\n" + 10**6 * "/" + "\n0,1,2\n",
    "quotes": "t,a,b\n" + 10**6 * '"' + "\n0,1,2\n",
    "JSON": '{"t":0,"a":1,"b":' + NINES + "}\n" + '{"t":' + 10**5 * "[" + "\n",
    "names of JSON": '{"' + 10**5 * "n" + '":' + json.dumps(10**5 * [0]) + "}\n",
    "deep JSON": 900 * '{"a":' + json.dumps(10**5 * [0]) + 900 * "}",
}


@pytest.mark.parametrize("form", LONG)
def test_no_line_takes_long(tmp_path, form):
    (tmp_path / "log.csv").write_text(LONG[form])
    began = time.process_time()
    with suppress(InputError):
        assert read_table(tmp_path / "log.csv", AB).values.shape[1] == 3
    assert time.process_time() - began < 2
