"""Joints of a model begin where its scenario says."""

from pathlib import Path

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

LINK = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>{mimic}</joint>"""


def scenario_of(folder: Path, positions: str) -> Scenario:
    follows = '<mimic joint="lead" multiplier="-2" offset="0.1"/>'
    joints = JOINT.format(name="lead", parent="foot", mimic="") + JOINT.format(
        name="follow", parent="lead_link", mimic=follows
    )
    links = "".join(f'<link name="{name}">{LINK}' for name in ("foot", "lead_link", "follow_link"))
    (folder / "crank.urdf").write_text(f'<robot name="crank">{links}{joints}</robot>')
    finger = "- {name: finger, file: package://soft_gripper/grippers/finger.urdf, X_PC: {translation: [0, 0, 9]}}"
    crank = f"- {{name: crank, file: crank.urdf, initial_position: {positions}}}"
    (folder / "scenario.yaml").write_text(f"models:\n{finger}\n{crank}\n")
    return load_scenario(folder / "scenario.yaml")


def test_joints_begin_there_and_others_follow(tmp_path: Path) -> None:
    station = make_station(scenario_of(tmp_path, "{lead: [0.2]}"))
    plant = station.plant
    context = plant.GetMyContextFromRoot(station.diagram.CreateDefaultContext())
    angles = [plant.GetJointByName(name).get_angle(context) for name in ("lead", "follow")]
    assert angles == pytest.approx([0.2, -0.3])


@pytest.mark.parametrize(
    ("positions", "joint"),
    [("{follow: [0.1]}", "follow"), ("{lead: [1.5]}", "lead"), ("{lead: [0, 0]}", "lead"), ("{elbow: [0]}", "elbow")],
)
def test_positions_that_are_refused(tmp_path: Path, positions: str, joint: str) -> None:
    with refused(f"initial_position.{joint}"):
        make_station(scenario_of(tmp_path, positions))


def test_an_arm_has_a_home() -> None:
    scenario = load_scenario("arm_motion", ["models.arm.initial_position={joint: [0.0]}"])
    with refused("initial_position"):
        make_station(scenario)
