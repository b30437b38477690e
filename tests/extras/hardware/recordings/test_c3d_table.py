"""C3D files of others: subjects, damage, and a library that crashes."""

import numpy as np
import pytest
from c3d_files import write_c3d
from hardware_files import swinging
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware import isolated_reading
from soft_gripper.extras.hardware.recordings import read_recording
from soft_gripper.extras.hardware.table import Columns
from soft_gripper.extras.hardware.table_files import read_table


def test_a_label_of_two_subjects_is_refused_without_the_subject(tmp_path, describe):
    labels = ("left:tip_1", "right:tip_1", "left:tip_3", "left:base_1")
    path = write_c3d(tmp_path / "a.c3d", swinging(), labels=labels)
    columns = Columns({"right:tip_1_x_mm": "markers"}, "time_s", points="{marker}_{axis}_mm", point_unit=1e-3)
    np.testing.assert_allclose(read_table(path, columns).values[:, 1], swinging()["tip_2_x_mm"], atol=1e-4)
    with refused("markers", "tip_1_x_mm") as error:
        read_recording(path, describe())
    assert "left:tip_1_x_mm, right:tip_1_x_mm" in str(error.value)


def test_modules_of_the_current_folder_are_not_run(tmp_path, describe, monkeypatch):
    path = write_c3d(tmp_path / "a.c3d", swinging())
    for name in ("resource", "pickle", "numpy", "json", "ezc3d"):
        (tmp_path / f"{name}.py").write_text("open('was_run', 'w')")
    monkeypatch.chdir(tmp_path)
    assert len(read_recording(path, describe()).time) == 200
    assert not (tmp_path / "was_run").exists()


def test_a_low_limit_on_memory_does_not_make_a_file_damaged(tmp_path, describe, monkeypatch):
    path = write_c3d(tmp_path / "a.c3d", swinging())
    monkeypatch.setattr(isolated_reading, "_MAX_MEMORY", 60 << 20)
    with pytest.raises(InputError, match="ulimit -v") as error:
        read_recording(path, describe())
    assert "damaged" not in str(error.value)
