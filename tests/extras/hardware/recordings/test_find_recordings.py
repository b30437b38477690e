"""Where files and their descriptions are looked for."""

import pytest
from hardware_files import DESCRIPTION, swinging, write_csv
from refusals import refused

from soft_gripper.extras.hardware.recordings import find_recordings


@pytest.fixture
def data(tmp_path):
    (tmp_path / "mine").mkdir()
    write_csv(tmp_path / "mine/run.csv", swinging())
    (tmp_path / "mine.yaml").write_text(DESCRIPTION)
    return tmp_path


def test_below_the_data_folder_or_that_of_the_environment(data, monkeypatch):
    for file in ("mine/run.csv", "run.csv"):
        (found,) = find_recordings([file], str(data / "mine.yaml"), data)
        assert found.name == "run"
    monkeypatch.setenv("SOFT_GRIPPER_DATA", str(data))
    assert len(find_recordings(["run.csv", "mine/run.csv"], str(data / "mine.yaml"))) == 2


def test_a_description_beside_the_file(data):
    file = [str(data / "mine/run.csv")]
    with refused("description", None):
        find_recordings(file)
    for name in ("recording.yaml", "run.yaml"):
        (data / "mine" / name).write_text(DESCRIPTION)
        assert len(find_recordings(file)) == 1


def test_no_file(data, monkeypatch):
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)
    for files, given in ((["walk.csv"], (str(data / "mine.yaml"), data)), (["walk.csv"], ("x.yaml",)), ([], ())):
        with refused("FILE", files[0] if files else []):
            find_recordings(files, *given)
