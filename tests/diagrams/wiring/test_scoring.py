"""The truth beside the estimates: each is compared with the truth of its own sample."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics, in_space
from soft_gripper.load.force_estimator import DELAY, SAMPLES
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.truth.poses import fingertip_error, pose_error

# Name, overrides, and a finger whose contact torque changes all the time.
STEPS = ["pressure.settle=0.4", "pressure.hold_samples=10"]
CHANGING = {
    "grasp": ("box_grasp", [*STEPS, "pressure.steps.all=[60e3, 100e3, 80e3, 120e3]"], "left_finger"),
    "peg": ("obstructed_inside", [*STEPS, "pressure.steps.all=[0, 60e3, 20e3, 120e3]"], "left_finger"),
}


@pytest.fixture(scope="module", params=CHANGING.values(), ids=CHANGING)
def changing(request):
    """The signals of one finger, by their names."""
    name, overrides, finger = request.param
    recording = simulate(load_scenario(name, overrides))
    return lambda signal: recording[f"{finger}.{signal}"].values


def test_the_torque_error_is_that_of_the_same_sample(changing):
    """The estimate belongs to two samples before."""
    estimate, truth = changing("external_torque"), changing("true_external_torque")
    assert DELAY == 2
    known = SAMPLES  # the first estimate, logged a sample later
    assert np.isnan(estimate[:known]).all()
    expected = estimate[known:] - truth[known - DELAY : -DELAY]
    np.testing.assert_array_equal(changing("external_torque_error")[known:], expected)
    assert np.ptp(truth, axis=0)[0] > 0.05


def test_the_pose_errors_are_those_of_the_same_sample(changing):
    chain = forward_kinematics(changing("sampled_joint_angles"), 0.01)
    true_joints, true_tip = in_space(chain.joints), in_space(chain.tip)
    np.testing.assert_allclose(changing("true_joint_positions"), true_joints, atol=1e-15)
    np.testing.assert_allclose(changing("true_tip_position"), true_tip, atol=1e-15)
    joints, tip = (in_space(as_planar(changing(name)[..., :2])) for name in ("joint_positions", "tip_pose"))
    np.testing.assert_allclose(changing("pose_error"), pose_error(true_joints, joints), atol=1e-15)
    np.testing.assert_allclose(changing("fingertip_error"), fingertip_error(true_tip, tip), atol=1e-15)


def test_the_pose_errors_of_a_finger_that_shears_are_those_of_the_plant(tmp_path):
    """In a grasp, in which its tip is millimetres away from where its joint angles alone would have it."""
    text = (DIRECTORY / "grippers/two_finger.urdf").read_text()
    (tmp_path / "gripper.urdf").write_text(text.replace("<body", '<body shear_factor="0.857"'))
    changes = [f"models.0.file={tmp_path / 'gripper.urdf'}", "pressure.steps.all=[100e3]", "pressure.settle=0.6"]
    station = make_station(load_scenario("box_grasp", [*changes, "pressure.hold_samples=2"]))
    recording = run_station(station)
    finger, plant = station.fingers[0], station.plant
    context = plant.CreateDefaultContext()
    last = recording.data.isel(time=-1)
    plant.SetPositionsAndVelocities(context, last["plant.state"].values)
    tip = plant.GetFrameByName("left_finger_tip", finger.model).CalcPose(context, finger.base.body_frame())
    x, _, z = tip.translation()
    estimated = as_planar(last["left_finger.tip_pose"].values[:2])
    assert last["left_finger.fingertip_error"].item() == pytest.approx(abs(z + 1j * x - estimated), abs=2e-5)
    bent = forward_kinematics(last["left_finger.sampled_joint_angles"].values, 0.01).tip
    assert abs(z + 1j * x - bent) > 2e-3
    np.testing.assert_allclose(last["left_finger.true_tip_position"], tip.translation(), atol=2e-5)
