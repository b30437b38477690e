"""Fingers in a plant of one's own: the same gripper twice, with a drive and sensing each, and what is refused."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from refusals import refused

from soft_gripper.diagrams.loaded_model import add_fingers, find_fingers
from soft_gripper.diagrams.recording import read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.sensing import add_sensing
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import PressureConfig

GRIPPER = "package://soft_gripper/grippers/two_finger.urdf"
PRESSURES = {  # Pa
    "near.left_finger": 80e3,
    "near.right_finger": 40e3,
    "far.left_finger": -30e3,
    "far.right_finger": 60e3,
}


def fingers_in(plant, file=GRIPPER, **options):
    return add_fingers(Parser(plant), file, **options)


def two_grippers(plant):
    """Side by side, each called by its model; they lie on their sides, so that weight bends no finger."""
    found = []
    for name, x in (("near", 0.0), ("far", 0.5)):
        found += fingers_in(plant, name=name)
        palm = plant.GetFrameByName("palm", plant.GetModelInstanceByName(name))
        plant.WeldFrames(plant.world_frame(), palm, RigidTransform([x, 0.0, 0.0]))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return found


@pytest.fixture(scope="module")
def driven():
    """The fingers of both grippers, and what was recorded of them under PRESSURES."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.01)
    fingers = two_grippers(plant)
    drive = add_pressure_drive(builder, fingers, PressureConfig())
    for name, pressure in PRESSURES.items():
        builder.Connect(builder.AddSystem(ConstantVectorSource([pressure])).get_output_port(), drive.commands[name])
    logs = add_logs(builder, add_sensing(builder, fingers, drive.pressures), 0.01)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.5)
    return fingers, read_logs(logs, simulator.get_context())


def test_fingers_are_named_by_their_model_where_names_repeat(driven):
    fingers, _ = driven
    assert [finger.name for finger in fingers] == list(PRESSURES)
    assert [finger.model_name for finger in fingers] == ["near", "near", "far", "far"]
    assert [finger.finger.name for finger in fingers] == 2 * ["left_finger", "right_finger"]


def test_every_finger_bends_under_its_own_pressure(driven):
    fingers, recording = driven
    for finger in fingers:
        free = PRESSURES[finger.name] * finger.finger.pressure_gain / finger.finger.stiffness
        for signal in ("sampled_joint_angles", "estimated_joint_angles"):
            bent = recording[f"{finger.name}.{signal}"].values[-1]
            np.testing.assert_allclose(bent, free, rtol=1e-3, err_msg=finger.name)
        assert recording[f"{finger.name}.pressure"].values[-1] == pytest.approx(PRESSURES[finger.name])
        assert np.abs(recording[f"{finger.name}.external_torque"].values[-1]).max() < 1e-4


def expanded(folder, file="grippers/two_finger.urdf"):
    path = folder / "plain.urdf"
    path.write_text(expand_urdf(DIRECTORY / file).text)
    return path


def test_fingers_of_an_expanded_file_are_found_in_a_plant_of_directives(tmp_path):
    """One of the two grippers is asked for."""
    plant = MultibodyPlant(0.01)
    model = "- add_model: {{name: {}, file: 'file://{}'}}\n- add_weld: {{parent: world, child: '{}::palm'}}\n"
    text = "".join(model.format(name, expanded(tmp_path), name) for name in ("one", "other"))
    (tmp_path / "scene.dmd.yaml").write_text(f"directives:\n{text}")
    Parser(plant).AddModels(str(tmp_path / "scene.dmd.yaml"))
    plant.Finalize()
    other = plant.GetModelInstanceByName("other")
    left, right = find_fingers(plant, GRIPPER, other)
    assert (left.name, right.name) == ("other.left_finger", "other.right_finger")
    bodies = {plant.get_body(index).index() for index in plant.GetBodyIndices(other)}
    assert {link.index() for finger in (left, right) for link in finger.links} < bodies
    assert left.finger.segments == len(left.joints) == 12


def test_another_models_fingers_are_refused(tmp_path):
    plant = MultibodyPlant(0.01)
    (model,) = Parser(plant).AddModels(str(expanded(tmp_path, "grippers/finger.urdf")))
    with refused("finger", "left_finger"):
        find_fingers(plant, GRIPPER, model)


@pytest.mark.parametrize(
    ("file", "field", "value"),
    [
        ("package://soft_gripper/arms/ur5e.urdf", "finger", None),
        ("package://soft_gripper/grippers/none.urdf", "file", "none.urdf"),
        (GRIPPER, "file", "two_finger.urdf"),
    ],
)
def test_what_cannot_be_added(file, field, value):
    """The last because its name is taken."""
    plant = MultibodyPlant(0.01)
    fingers_in(plant)
    with refused(field, value):
        fingers_in(plant, file)


def test_limits_of_zero_do_not_hold_a_joint_that_follows(tmp_path):
    """The thumb of a gripper in a plant of one's own."""
    link = "<link name='{}'><inertial><mass value='0.1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
    joint = "<joint name='{0}' type='prismatic'><parent link='palm'/><child link='{0}'/><axis xyz='0 1 0'/>{1}</joint>"
    lead = joint.format("lead", "<limit lower='0' upper='0.1' velocity='1' effort='1'/>")
    thumb = joint.format("thumb", "<limit lower='0' upper='0' velocity='0' effort='0'/><mimic joint='lead'/>")
    text = (DIRECTORY / "grippers" / "two_finger.urdf").read_text(encoding="utf-8")
    added = f"{link.format('lead')}{link.format('thumb')}{lead}{thumb}</robot>"
    (tmp_path / "gripper.urdf").write_text(text.replace("</robot>", added), encoding="utf-8")
    plant = MultibodyPlant(0.01)
    fingers_in(plant, str(tmp_path / "gripper.urdf"))
    assert plant.GetJointByName("thumb").position_upper_limits() == [np.inf]
    assert plant.GetJointByName("thumb").velocity_upper_limits() == [np.inf]
