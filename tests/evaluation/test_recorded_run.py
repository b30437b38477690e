"""A recording is read with its scenario and its fingers; what is none is refused."""

import pytest

from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.evaluation.recorded_run import load_run, read_signal


def test_scenario_and_fingers_come_back(tmp_path):
    overrides = ["pressure.steps.all=[0]", "pressure.settle=0.02", "pressure.hold_samples=2", "sensor.sections=3"]
    simulate(load_scenario("free_bending", overrides)).save(tmp_path / "recording.nc")
    recording, scenario, fingers = load_run(tmp_path / "recording.nc")
    assert [finger.name for finger in fingers] == ["left_finger", "right_finger"]
    assert scenario.sensor.sections == 3
    assert read_signal("file", recording, "left_finger.sampled_joint_angles").shape == (5, 12)
    with pytest.raises(InputError, match=r"file: signal = 'left_finger.temperature': is not in the recording"):
        read_signal("file", recording, "left_finger.temperature")


@pytest.mark.parametrize("content", [None, b"no netCDF"])
def test_what_is_no_recording_is_refused(tmp_path, content):
    file = tmp_path / "recording.nc"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match="is no recording of a scenario"):
        load_run(file)
