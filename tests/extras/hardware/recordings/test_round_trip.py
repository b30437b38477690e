"""A simulated motion, written in every form of file, read and identified: the same finger."""

import json
from functools import partial

import numpy as np
import pytest
import xarray as xr
from c3d_files import write_c3d
from hardware_files import write_csv
from identified import BEAM, RELEASED, finger_of, motion_columns, recorded, release
from log_forms import FORMS, drawn, table

from soft_gripper.diagrams.recording_file import write_netcdf
from soft_gripper.extras.hardware.identification.identified_finger import identify
from soft_gripper.extras.hardware.identification.simulated_motion import measured_motion
from soft_gripper.extras.hardware.recordings import read_recording

MARKERS = "tip_1", "tip_2", "tip_3"
OF_BAG = RELEASED.replace("time: time_s", "time: /m/tip_1.header.stamp").replace(
    '"{marker}_{axis}_mm"', '"/m/{marker}.point.{axis}"'
)


def write_bag(path, columns, plugin="", part=""):
    pytest.importorskip("rosbags", reason="bags take rosbags and mcap: pip install 'soft-gripper[ros]'")
    import bag_files
    from rosbags.rosbag2 import StoragePlugin

    points = {
        f"/m/{name}": (columns["time_s"], np.column_stack([columns[f"{name}_{axis}_mm"] for axis in "xyz"]))
        for name in MARKERS
    }
    write = bag_files.write_json_mcap if path.suffix == ".mcap" else bag_files.write_ros
    storage = {"plugin": StoragePlugin[plugin]} if plugin else {}
    path = write(path, points, dict.fromkeys(points, bag_files.POINT), **storage)
    return next(path.glob(part)) if part else path


def write_data(path, columns, write):
    write(xr.Dataset({name: ("t", values) for name, values in columns.items()}), path)
    return path


def write_json(path, columns, lines):
    cells = np.column_stack(list(columns.values())).tolist()
    rows = [{n: None if v != v else v for n, v in zip(columns, row, strict=True)} | {"device": {}} for row in cells]
    path.write_text("\n".join(map(json.dumps, rows)) if lines else json.dumps(rows, indent=1))
    return path


FILES = {
    "C3D, mm": ("a.c3d", write_c3d),
    "C3D, m": ("a.c3d", partial(write_c3d, unit="m")),
    "C3D with a subject": ("a.c3d", partial(write_c3d, labels=[f"Beam:{name}" for name in MARKERS])),
    "netCDF 3": ("a.nc", partial(write_data, write=lambda data, path: data.to_netcdf(path, engine="scipy"))),
    "netCDF 4": ("a.nc", partial(write_data, write=write_netcdf)),
    "JSON": ("a.json", partial(write_json, lines=False)),
    "lines of JSON": ("a.json", partial(write_json, lines=True)),
    "ROS 1": ("a.bag", write_bag),
    "ROS 2, SQLite": ("bag", partial(write_bag, plugin="SQLITE3")),
    "ROS 2, MCAP": ("bag", partial(write_bag, plugin="MCAP")),
    "ROS 2, one database": ("bag", partial(write_bag, plugin="SQLITE3", part="*.db3")),
    "ROS 2, one MCAP file": ("bag", partial(write_bag, plugin="MCAP", part="*.mcap")),
    "MCAP of JSON": ("a.mcap", write_bag),
}
TEXTS = FORMS | {f"drawn {seed}": partial(drawn, seed=seed) for seed in range(30)}


@pytest.fixture(scope="module")
def columns(beam):
    """Of a beam that is released."""
    motion = recorded(beam, release(0.8))
    return motion_columns(motion.time, motion.markers)


def read(path, describe, more="", text=RELEASED):
    """What is identified follows from the motion."""
    recording = read_recording(path, describe(more, text))
    return measured_motion(recording), [note.why for note in recording.notes]


def assert_alike(found, plain):
    np.testing.assert_allclose(found.time, plain.time, atol=1e-6)
    np.testing.assert_allclose(found.markers, plain.markers, atol=1e-8)
    np.testing.assert_allclose(found.events, plain.events, atol=1e-6)


def test_the_finger_that_made_a_file_is_identified(columns, tmp_path, describe, pool):
    motion, _ = read(write_csv(tmp_path / "a.csv", columns), describe)
    guess = finger_of(BEAM.replace('material="dragon_skin_10"', 'youngs_modulus="2.75e5" density="1070"'), tmp_path)
    found = identify(guess, ["youngs_modulus"], [motion], [], pool)
    assert found.model.finger.base.youngs_modulus == pytest.approx(2.64e5, rel=0.01)


@pytest.mark.parametrize("kind", FILES)
def test_every_kind_of_file_says_the_same(columns, tmp_path, describe, kind):
    """Also that a marker is not seen for a moment."""
    lost = np.where(np.arange(80) // 5 == 14, np.nan, columns["tip_2_x_mm"])
    (name, write), columns = FILES[kind], columns | {"tip_2_x_mm": lost}
    plain, why = read(write_csv(tmp_path / "a.csv", columns), describe)
    text = OF_BAG if "ROS" in kind or "MCAP" in kind else RELEASED
    found, same = read(write(tmp_path / name, columns), describe, text=text)
    assert_alike(found, plain)
    assert same == why


@pytest.mark.parametrize("form", TEXTS)
def test_every_form_of_text_says_the_same(columns, tmp_path, describe, form):
    plain, written = TEXTS["plain"](table(columns)), TEXTS[form](table(columns))
    motions = []
    for name, content in (("a.csv", plain), ("log.csv", written)):
        (tmp_path / name).write_bytes(content.content)
        motion, notes = read(tmp_path / name, describe, content.more)
        motions.append(motion)
    assert_alike(*motions)
    assert bool(notes) == written.noted, notes
