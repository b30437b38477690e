"""Calibration from recordings: what it finds, what estimation gains from it, and recordings that are refused."""

from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.calibration import calibrate_recordings
from soft_gripper.scenario.calibration_file import load_calibration
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

STEPS = ["pressure.steps.all=[0, 60e3, 120e3, 60e3, -30e3]", "pressure.settle=0.5", "pressure.hold_samples=20"]
NOMINAL = ["nominal.finger.youngs_modulus=+15 %", "nominal.finger.layer_modulus=+15 %"]  # the neutral axis stays
ERRORS = "sensor.errors={gain_error: 0.05, offset: 0.005, noise: 0.001, hysteresis: 0.005}"
WRONG = [*STEPS, *NOMINAL, ERRORS, "sensor.seed=3"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Records a scenario; the path of the recording."""
    done = {}

    def record(name, *overrides):
        key = (name, *overrides)
        if key not in done:
            done[key] = tmp_path_factory.mktemp("recording") / "recording.nc"
            simulate(load_scenario(name, overrides)).save(done[key])
        return done[key]

    return record


def test_a_calibrated_nominal_model_estimates_better(recorded, tmp_path):
    """The same sensors again, by the command line and a scenario that loads what it wrote."""
    path, out = recorded("free_bending", *WRONG), tmp_path / "calibration.yaml"
    result = soft_gripper("calibrate", path, "--out", out)
    assert result.code == 0, result.err
    assert "a common gain and the bend per pressure cannot be told apart" in result.out
    assert load_calibration(str(out)).fingers["left_finger"].bend_ratio == pytest.approx(1.15, rel=0.05)
    after = simulate(load_scenario("free_bending", [*WRONG, f"nominal.calibration={out}"]))
    for signal, part in (("pose_error", 0.6), ("external_torque", 0.4)):
        assert mean_of_fingers(after, signal) < part * mean_of_fingers(Recording.load(path), signal)


def mean_of_fingers(recording, signal):
    return sum(np.nanmean(np.abs(recording[f"{f}.{signal}"][20:])) for f in ("left_finger", "right_finger"))


def refused(*paths):
    with pytest.raises(InputError) as caught:
        calibrate_recordings([Path(path) for path in paths])
    return str(caught.value)


@pytest.mark.parametrize("name", ["box_grasp", "obstructed_inside"])
def test_contact_is_refused(recorded, name):
    assert "something was touched, or it is a different finger" in refused(recorded(name, *STEPS))


def test_too_little_motion_is_refused(recorded):
    assert "too little motion at rest" in refused(recorded("free_bending", *STEPS, "pressure.steps.all=[0, 2e3]"))


def test_a_section_that_the_pressure_does_not_bend_is_refused(recorded):
    """Of the conforming gripper in free air."""
    in_air = ["models=[{name: gripper, file: package://soft_gripper/grippers/conforming.urdf}]", "gravity=[0, 0, 0]"]
    path = recorded("conforming_grasp", *STEPS, *in_air, "pressure.steps.all=[0, 60e3, -30e3]")
    assert "section 2 hardly moves" in refused(path)
