"""Files that are not what their description says: refused in a line that names file, field and value."""

import gzip
import io
import re

import numpy as np
import pytest
from hardware_files import swinging, write_csv
from log_forms import Content, joined, table

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recordings import read_recording


def changed(**columns):
    return {**swinging(), **columns}


def scaled(size):
    return {name: size * values if "mm" in name else values for name, values in swinging().items()}


def exchanged(names, span):
    columns = swinging()
    for axis in "xyz":
        a, b = (columns[f"{name}_{axis}_mm"] for name in names)
        a[span], b[span] = b[span].copy(), a[span].copy()
    return columns


def with_number(column, row, value):
    columns = swinging()
    columns[column][row:] = value + np.arange(200 - row) / 100 if column == "time_s" else columns[column][row:]
    columns[column][row] = value
    return columns


def npy():
    file = io.BytesIO()
    np.save(file, np.zeros((3, 13)))
    return file.getvalue()


def text(old="", new="", separator=",", decimal="."):
    return joined(table(swinging()), separator, decimal).replace(old, new, 1).encode()


def cells(*values):
    """A log with the same cells in all rows but for the time."""
    return joined(Content([*swinging()], [[str(i), *values] for i in range(200)]), ";").encode()


TIME = swinging()["time_s"]
SEVEN = {name: values for name, values in swinging().items() if name != "tip_2_y_mm"}
LOST = {f"tip_{i}_{axis}_mm": np.full(200, np.nan) for i in (1, 2, 3) for axis in "xyz"}
HEAD = ",".join(swinging()).encode() + b"\n"
NANOSECONDS = joined(Content([*swinging()], [[f"{i}0000000", *12 * ["1"]] for i in range(200)])).encode()
COLUMNS = {
    "tip_2_y_mm': no such column; did you mean 'tip_": SEVEN,
    "time_s.*runs backwards in row 52": changed(time_s=np.roll(TIME, 50)),
    "time_s.*most rows repeat a time": changed(time_s=np.floor(TIME)),
    "samples with a time": changed(time_s=np.full(200, np.nan)),
    "markers.unit": scaled(1000),
    "is the unit right[?]": scaled(1e-3),
    "tip_1, tip_3': swap names at 1.20, 1.50 s": exchanged(("tip_1", "tip_3"), slice(120, 150)),
    "swap names at 1.20 s": exchanged(("tip_1", "base_1"), slice(120, None)),
    "tip_1, tip_2': their distance changes by .* on one rigid body[?] Markers along a finger need a body each": changed(
        tip_1_x_mm=swinging()["tip_1_x_mm"] + 20 * TIME
    ),
    "are their markers exchanged[?]": changed(base_1_x_mm=20 + 40 * np.sin(TIME)),
    "none of them is ever seen": changed(**LOST),
    "time_s = 1000000000.0.*before row 102, after 0.99": with_number("time_s", 100, 1e9),
    "tip_1_x_mm = 1e[+]308: in row 9": with_number("tip_1_x_mm", 7, 1e308),
    "tip_1_x_mm = -inf: in row 9": with_number("tip_1_x_mm", 7, -np.inf),
    "time_s = inf: in row 201": with_number("time_s", 199, np.inf),
}
TEXTS = {
    "MATLAB 7.3.*writetable": b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n",
    "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(100),
    "workbook": b"PK\x03\x04" + bytes(100),
    "numpy.savetxt": npy(),
    "unpack": gzip.compress(text()),
    "Motive.*C3D": b"Format Version,1.23,Take Name,Take 1\n\n,,Marker,Marker,Marker\nFrame,Time,X,Y,Z\n0,0.0,1,2,3\n",
    "TRC.*C3D": b"PathFileType\t4\t(X/Y/Z)\ta.trc\nFrame#\tTime\ttip\n1\t0.0\t1\n",
    "not a text file": bytes(range(256)),
    "decimal": cells(*12 * ["2,036"]),
    "only .* rows are numbers": text(separator=",", decimal=","),
    "'12 mm' for base_1_x_mm, which is not a number: leave units out": cells(*12 * ["12 mm"]),
    "`time_unit`": NANOSECONDS,
    "did you mean 'tip1_x_mm'": text("tip_1_x", "tip1_x"),
    "tip_1_x_mm': 2 columns": text("tip_2_x_mm", "tip_1_x_mm"),
}
EMPTY = b"", b"nothing,here\n", 12 * b"," + b"\n"
DESCRIBED = {
    "pressures.unit = 'bar'": (changed(p=np.full(200, 1e5)), "pressures: {columns: [p], unit: bar}"),
    "lengths.unit or scale = 'V'": (
        changed(wire=1 + TIME),
        "lengths: {wires: {a: {column: wire}}, unit: V, scale: 200, spacing: 0.04}",
    ),
    "pressure in p = '101.3 kPa at rest': .*ambient": (
        changed(p=101.325 + 0.6 * (TIME > 1) * TIME),
        "pressures: {columns: [p], unit: kPa}",
    ),
}


CASES = [
    *((said, content, "") for said, content in (COLUMNS | TEXTS).items()),
    *(("file = 'bad.csv'", HEAD + rows, "") for rows in EMPTY),
    *((said, *given) for said, given in DESCRIBED.items()),
]


@pytest.mark.parametrize(("said", "content", "more"), CASES, ids=[said for said, *_ in CASES])
def test_what_cannot_be_is_refused(tmp_path, describe, said, content, more):
    path = tmp_path / "bad.csv"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        write_csv(path, content)
    with pytest.raises(InputError) as error:
        read_recording(path, describe(more))
    assert error.value.where == path
    assert re.search(said, str(error.value)), error.value
