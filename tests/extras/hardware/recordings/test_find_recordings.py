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


def test_as_given(data):
    (found,) = find_recordings([str(data / "mine/run.csv")], str(data / "mine.yaml"))
    assert found.name == "run"


@pytest.mark.parametrize("file", ["mine/run.csv", "run.csv"])
def test_below_the_data_folder(data, file):
    (found,) = find_recordings([file], str(data / "mine.yaml"), data)
    assert found.name == "run"


def test_below_the_environments_folder(data, monkeypatch):
    monkeypatch.setenv("SOFT_GRIPPER_DATA", str(data))
    assert len(find_recordings(["run.csv", "mine/run.csv"], str(data / "mine.yaml"))) == 2


@pytest.mark.parametrize("name", ["run.yaml", "recording.yaml"])
def test_a_description_beside_the_file(data, name):
    (data / "mine" / name).write_text(DESCRIPTION)
    assert len(find_recordings([str(data / "mine/run.csv")])) == 1


def test_no_description(data):
    with refused("description", None):
        find_recordings([str(data / "mine/run.csv")])


def test_no_file(data, monkeypatch):
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)
    with refused("FILE", "walk.csv"):
        find_recordings(["walk.csv"], str(data / "mine.yaml"), data)
    with refused("FILE", "walk.csv"):
        find_recordings(["walk.csv"], str(data / "mine.yaml"))
    with refused("FILE", []):
        find_recordings([])
