"""The phases of a task, planned for a gantry: three slides and a wrist that turns, with one posture for every pose."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from arm_plants import joint, small_arm
from pydrake.common.schema import Rotation, Transform
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene, arm_of

from soft_gripper.control.arm_motion import tool_pose
from soft_gripper.diagrams.task_plan import RESCUE, end_of, plan_phases
from soft_gripper.scenario.schema import ModelConfig, PhaseConfig, PoseErrorConfig, TaskConfig

GANTRY = "".join(
    joint("prismatic", parent, child, axis) + f"<link name='{child}'/>"
    for parent, child, axis in (("base", "x", "1 0 0"), ("x", "y", "0 1 0"), ("y", "z", "0 0 1"))
)
GANTRY += joint("revolute", "z", "flange") + "<link name='flange'/>"
HOME = [0.1, -0.2, 1.0, 0.0]  # x, y, z in m, turn in rad
POSTURE = [0.3, 0.1, 1.2, 0.2]
BEGIN, GOAL = [0.5, -0.4, 0.2, 0.3], [0.4, 0.6, 0.2, -0.5]  # of the object, in the same coordinates
GRASP = [0.0, 0.0, 0.05, 0.1]  # of the gripper in the object
OVER, HIGHEST = 0.15, 0.25  # m
THING = """<robot name="thing"><link name="thing"><inertial><mass value="0.1"/>
  <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""

PICK_AND_PLACE = (
    PhaseConfig("look", posture=POSTURE, opening=0.1, rest=0.4),
    PhaseConfig("approach", "object", OVER, until="opened"),
    PhaseConfig("descend", "object", straight=True),
    PhaseConfig("close", opening=0.03, until="grasped"),
    PhaseConfig("lift", "object", OVER, straight=True, holds=True),
    PhaseConfig("carry", "goal", HIGHEST, holds=True),
    PhaseConfig("lower", "goal", straight=True, holds=True, rest=0.3),
    PhaseConfig("release", opening=0.09, until="released"),
    PhaseConfig("return", "home"),
)
NAMES = [config.name for config in PICK_AND_PLACE]
WATCHED = ["approach", "close", "lift", "carry", "lower", "release"]


def pose(coordinates):
    """Of something that lies there."""
    *position, turn = coordinates
    return RigidTransform(RollPitchYaw(0, 0, turn), position)


def schema(coordinates):
    *position, turn = coordinates
    return Transform(translation=position, rotation=Rotation(value=Rotation.Rpy(deg=[0, 0, np.rad2deg(turn)])))


def plan(folder, *configs, error=None):
    (folder / "thing.urdf").write_text(THING)
    scenario = small_arm(folder, GANTRY, HOME)
    scenario.models.append(ModelConfig("thing", str(folder / "thing.urdf"), X_PC=schema(BEGIN), free=True))
    task = TaskConfig("thing", schema(GRASP), schema(GOAL), list(configs), pose_error=error or PoseErrorConfig())
    arm = arm_of(scenario, add_scene(DiagramBuilder(), scenario))
    return arm, plan_phases(task, scenario.models, arm)


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """The arm, and the phases of PICK_AND_PLACE."""
    return plan(tmp_path_factory.mktemp("gantry"), *PICK_AND_PLACE)


def begin_of(phase):
    return phase.motion.value(0.0)[:, 0]


def rescue_of(phases, name):
    """The phases that follow the failure of a phase, one after the other."""
    number, found = phases[NAMES.index(name)].rescue, []
    while number != len(phases):
        assert len(found) < len(RESCUE)
        found.append(phases[number])
        number = phases[number].follower
    return found


def test_every_phase_begins_where_the_one_before_ended(planned):
    _, phases = planned
    np.testing.assert_allclose(begin_of(phases[0]), HOME, atol=1e-12)
    for one, other in pairwise(phases[: len(NAMES)]):
        np.testing.assert_allclose(begin_of(other), end_of(one.motion), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "place", "height"),
    [
        ("approach", BEGIN, OVER),
        ("descend", BEGIN, 0),
        ("close", BEGIN, 0),
        ("lift", BEGIN, OVER),
        ("carry", GOAL, HIGHEST),
        ("lower", GOAL, 0),
        ("release", GOAL, 0),
    ],
)
def test_where_a_phase_ends(planned, name, place, height):
    """The gripper grasps the object, or is above where it does."""
    arm, phases = planned
    X_WTool = RigidTransform([0, 0, height]) @ pose(place) @ pose(GRASP)
    found = tool_pose(arm.plant, arm.tool, end_of(phases[NAMES.index(name)].motion))
    assert found.IsNearlyEqualTo(X_WTool, 2e-6)


@pytest.mark.slow
def test_the_object_is_grasped_where_it_is_reported_and_put_down_as_if_that_were_right(tmp_path):
    arm, phases = plan(tmp_path, *PICK_AND_PLACE, error=PoseErrorConfig(0.03, -0.02, 0.4))
    x, y, z, turn = BEGIN
    for name, place in (("descend", (x + 0.03, y - 0.02, z, turn + 0.4)), ("lower", GOAL)):
        found = tool_pose(arm.plant, arm.tool, end_of(phases[NAMES.index(name)].motion))
        assert found.IsNearlyEqualTo(pose(place) @ pose(GRASP), 2e-6)


def middle(arm, phase):
    return tool_pose(arm.plant, arm.tool, phase.motion.value(phase.duration / 2)[:, 0])


def test_what_phases_are_taken_over_from_the_scenario(planned):
    _, phases = planned
    own = phases[: len(NAMES)]
    assert [phase.name for phase in own] == NAMES
    assert [(p.until, p.rest, p.holds) for p in own] == [(c.until, c.rest, c.holds) for c in PICK_AND_PLACE]
    assert [phase.opening for phase in own] == [0.1] * 3 + [0.03] * 4 + [0.09] * 2
    assert [phase.follower for phase in own] == [*range(1, len(NAMES)), len(phases)]


def test_only_what_can_fail_has_a_rescue(planned):
    _, phases = planned
    assert [phase.name for phase in phases if phase.rescue is not None] == WATCHED
    assert len(phases) == len(NAMES) + len(RESCUE) * len(WATCHED)
    assert len({phase.rescue for phase in phases[: len(NAMES)]}) == len(WATCHED) + 1


@pytest.mark.parametrize("name", WATCHED)
def test_rescue_opens_rises_and_goes_home(planned, name):
    arm, phases = planned
    failed = phases[NAMES.index(name)]
    opened, risen, home = rescue = rescue_of(phases, name)
    assert tuple(phase.name for phase in rescue) == RESCUE
    assert [phase.until for phase in rescue] == ["released", None, None]
    assert [phase.opening for phase in rescue] == [0.1] * 3
    assert not any(phase.holds for phase in rescue)
    for one, other in pairwise([failed, opened, risen, home]):
        np.testing.assert_allclose(begin_of(other), end_of(one.motion), atol=1e-12)
    np.testing.assert_allclose(end_of(opened.motion), begin_of(opened), atol=1e-12)
    np.testing.assert_allclose(end_of(home.motion), HOME, atol=1e-12)
    rise = HIGHEST - PICK_AND_PLACE[NAMES.index(name)].height
    X_WTool = RigidTransform([0, 0, rise]) @ tool_pose(arm.plant, arm.tool, begin_of(risen))
    assert tool_pose(arm.plant, arm.tool, end_of(risen.motion)).IsNearlyEqualTo(X_WTool, 2e-6)
    assert middle(arm, risen).translation()[:2] == pytest.approx(X_WTool.translation()[:2], abs=1e-5)


def test_half_the_speed_takes_twice_as_long(tmp_path):
    _, phases = plan(
        tmp_path,
        PhaseConfig("there", posture=POSTURE, opening=0.1),
        PhaseConfig("back", "home", speed=0.5, rest=3.0),
        PhaseConfig("up", "object", OVER, straight=True),
        PhaseConfig("away", posture=HOME, speed=0.25),
        PhaseConfig("slowly up", "object", OVER, straight=True, speed=0.25),
    )
    there, back, up, _, slowly_up = (phase.duration for phase in phases)
    assert back == pytest.approx(2 * there, rel=1e-6)
    assert slowly_up == pytest.approx(4 * up, rel=1e-6)


def plan_of_arm(
    folder, *, xyz="0 0 0", effort=1e3, mass=2.0, damping=0.0, gravity=9.81, error=0.0, height=OVER, **config
):
    """A plan for a gantry with these numbers, all of which bear on it."""
    last = joint("revolute", "z", "flange", xyz=xyz, effort=effort)
    last = last.replace("</joint>", f"<dynamics damping='{damping}'/></joint>")
    scenario = small_arm(folder, GANTRY[: GANTRY.index('<joint name="revolute')] + last + "<link name='flange'/>", HOME)
    hand = folder / "hand.urdf"
    hand.write_text(hand.read_text().replace('<mass value="2.0"/>', f'<mass value="{mass}"/>'))
    (folder / "thing.urdf").write_text(THING)
    scenario.models.append(ModelConfig("thing", str(folder / "thing.urdf"), X_PC=schema(BEGIN), free=True))
    scenario.gravity = [0.0, 0.0, -gravity]
    scenario.arm = replace(scenario.arm, **config)
    above = PhaseConfig("above", "object", height)
    task = TaskConfig("thing", schema(GRASP), schema(GOAL), [above], pose_error=PoseErrorConfig(x=error))
    return plan_phases(task, scenario.models, arm_of(scenario, add_scene(DiagramBuilder(), scenario)))


@pytest.mark.parametrize(
    "change",
    [
        {"xyz": "0 0 1e-9"},
        {"effort": 999.0},
        {"mass": 2.000001},
        {"damping": 1e-6},
        {"gravity": 9.8},
        {"error": 1e-9},
        {"height": OVER + 1e-9},
        {"home": [*HOME[:3], 1e-9]},
        {"acceleration": 9.0},
    ],
)
def test_whatever_changes_a_plan_makes_another(tmp_path, change):
    assert plan_of_arm(tmp_path) is not plan_of_arm(tmp_path, **change)
