"""Signals of the plant, and the truth beside the estimates."""

import numpy as np
import pytest
from arm_plants import MASS, joint, motor, small_arm

from soft_gripper.diagrams.recording import read_logs
from soft_gripper.diagrams.simulation import make_simulator, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.plant_signals import state_units
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics, in_space
from soft_gripper.load.force_estimator import DELAY, SAMPLES
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.truth.poses import fingertip_error, pose_error

# The file names the last joint first, and the motors in the order of the file.
LIFT, TURN = "prismatic_to_carriage", "revolute_to_flange"
JOINTS = joint("revolute", "carriage", "flange") + joint("prismatic", "base", "carriage")
UNCOUPLED = f'<link name="flange"/><link name="carriage"/>{JOINTS}{motor(TURN)}{motor(LIFT)}'
WEIGHT = (MASS + 2e-3) * 9.81  # N, of the hand and of two links, which weigh a gram each


@pytest.fixture(scope="module")
def grasp():
    """The station of a short box grasp, and what it recorded."""
    station = make_station(load_scenario("box_grasp", ["pressure.steps.all=[60e3]", "pressure.settle=0.5"]))
    simulator = make_simulator(station)
    simulator.AdvanceTo(1.5)
    return station, read_logs(station.logs, simulator.get_context())


def test_units_of_a_state(grasp):
    station, recording = grasp
    units = dict(zip(station.plant.GetStateNames(), state_units(station.plant), strict=True))
    assert units["box_box_qw"] == "1"
    assert units["box_box_x"] == "m"
    assert units["box_box_wx"] == "rad/s"
    assert units["box_box_vx"] == "m/s"
    assert units["gripper_left_finger_joint_3_q"] == "rad"
    assert units["gripper_left_finger_joint_3_w"] == "rad/s"
    assert recording["plant.state"]["state_units"].values.tolist() == list(units.values())
    assert recording["plant.state"]["state"].values.tolist() == list(units)


def test_the_contact_wrench_carries_an_object_with_joints_of_its_own(tmp_path):
    inertia = "<inertia><ixx>1e-6</ixx><iyy>1e-6</iyy><izz>1e-6</izz></inertia>"
    link = f'<link name="weight"><inertial><mass>0.02</mass>{inertia}</inertial></link>'
    axis = "<axis><xyz>1 0 0</xyz><dynamics><damping>1</damping></dynamics></axis>"
    joint = f'<joint name="slide" type="prismatic"><parent>box</parent><child>weight</child>{axis}</joint>'
    box = (DIRECTORY / "objects/box.sdf").read_text()
    (tmp_path / "box.sdf").write_text(box.replace("</model>", f"{link}{joint}</model>"))
    changes = ("pressure.steps.all=[0.0]", "pressure.settle=0.5", f"models.2.file={tmp_path}/box.sdf")
    wrench = simulate(load_scenario("box_grasp", changes)).data["box.contact_wrench"]
    assert wrench.sel(wrench="force_z").values[-1] == pytest.approx(0.07 * 9.81, rel=1e-3)


def test_the_contact_wrench_acts_about_the_origin_of_the_object(grasp):
    """Oracle: all contact surfaces of the box, each with its force and moment about its centre, in the world."""
    station, _ = grasp
    simulator = make_simulator(station)
    simulator.AdvanceTo(0.3)  # the fingers still close: the wrench turns, too
    plant, context = station.plant, station.plant.GetMyContextFromRoot(simulator.get_context())
    results = plant.get_contact_results_output_port().Eval(context)
    box = plant.GetBodyByName("box")
    shapes, origin, expected = plant.GetCollisionGeometriesForBody(box), box.EvalPoseInWorld(context), np.zeros(6)
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface, on_m = info.contact_surface(), info.F_Ac_W()
        sign = 1 if surface.id_M() in shapes else -1 if surface.id_N() in shapes else 0
        moment = on_m.rotational() + np.cross(surface.centroid() - origin.translation(), on_m.translational())
        expected += sign * np.concatenate([moment, on_m.translational()])
    found = station.diagram.GetOutputPort("box.contact_wrench").Eval(simulator.get_context())
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """What is recorded of a slide that carries a wrist, held where it begins."""
    scenario = small_arm(tmp_path_factory.mktemp("arm"), UNCOUPLED, [0.25, 0.5])
    scenario.pressure.settle, scenario.pressure.hold_samples = 0.3, 1
    return simulate(scenario)


def test_signals_of_an_arm_are_in_the_order_of_its_joints(small):
    """Whatever the order of its motors."""
    for name, units in (
        ("joint_positions", ["m", "rad"]),
        ("joint_velocities", ["m/s", "rad/s"]),
        ("joint_torques", ["N", "N m"]),
    ):
        signal = small[f"arm.{name}"]
        (axis,) = signal.dims[1:]
        assert signal[axis].values.tolist() == [LIFT, TURN]
        assert signal[f"{axis}_units"].values.tolist() == units
    np.testing.assert_allclose(small["arm.joint_positions"].values[-1], [0.25, 0.5], atol=1e-6)
    np.testing.assert_allclose(small["arm.joint_velocities"].values[-1], 0.0, atol=1e-6)
    np.testing.assert_allclose(small["arm.joint_torques"].values[-1], [WEIGHT, 0.0], atol=1e-6)


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
