"""`calibrate` on the recording of a finger that an independent script bends: its true gains, offsets and ratio."""

import numpy as np
import pytest
import xarray as xr
from command_line import soft_gripper
from synthetic_hardware import CALIBRATION, free_bending

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.hardware import calibration
from soft_gripper.scenario.calibration_file import load_calibration
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

ONE_FINGER = """models:
- name: left_finger
  file: package://soft_gripper/grippers/finger.urdf
gravity: [0, 0, 0]
sensor: {sections: 4, period: 0.02}
"""


@pytest.fixture
def recorded(tmp_path):
    """The recording, as `soft-gripper run` would write it of a scenario."""

    def save(name, *overrides, shift=0.0):
        (tmp_path / "one_finger.yaml").write_text(ONE_FINGER)
        scenario = load_scenario(str(tmp_path / "one_finger.yaml"), overrides)
        time, pressure, strain = free_bending()
        base = np.tile(np.eye(3, 4), (len(time), 1, 1))
        signals = {
            "left_finger.sampled_pressure": (["time"], pressure),
            "left_finger.strain": (["time", "path", "section"], strain + shift),
            "left_finger.X_WB": (["time", "row", "column"], base),
        }
        file = tmp_path / f"{name}.nc"
        Recording(xr.Dataset(signals, {"time": time}, {"scenario": dump_scenario(scenario)})).save(file)
        return file

    return save


def calibrate(file, out):
    result = soft_gripper("calibrate", file, "--out", out)
    assert result.code == 0, result.err
    return load_calibration(str(out)).fingers["left_finger"], result


@pytest.mark.slow
def test_the_truth_is_found(recorded, tmp_path):
    """While the pressure changes, the finger lags: samples that are not at rest would pull every number."""
    found, result = calibrate(recorded("run"), tmp_path / "calibration.yaml")
    assert found.bend_ratio == pytest.approx(CALIBRATION.bend_ratio, rel=5e-3)
    inner, outer = np.split(np.array(found.gains) - CALIBRATION.gains, 2)
    assert np.abs(inner).max() < 0.012  # near the layer, where the strain is some ten times its noise
    assert np.abs(outer).max() < 3e-3
    np.testing.assert_allclose(found.offsets, CALIBRATION.offsets, atol=3e-4)
    assert found.residual < CALIBRATION.noise  # of medians
    assert f"bends {found.bend_ratio:.4f} +- " in result.out


def test_weight_pulls_as_the_base_stands_in_each_sample(recorded):
    """A finger that stands, and hangs from the middle of the recording on."""
    file = recorded("run", "gravity=[0, 0, -9.81]")
    data = Recording.load(file).data
    data["left_finger.X_WB"].values[data.sizes["time"] // 2 :, :, :3] = np.diag([-1.0, 1.0, -1.0])
    Recording(data).save(file)
    ((_, samples),) = calibration._run_recordings(file)
    half = len(samples.gravity) // 2
    np.testing.assert_allclose(samples.gravity[: half - 5], -9.81)
    np.testing.assert_allclose(samples.gravity[half + 5 :], 9.81)
