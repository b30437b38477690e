"""What collides on the way of an arm, and is refused before it moves."""

import re
from dataclasses import replace

import numpy as np
import pytest
from arm_plants import joint, small_arm
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PathParameterizedTrajectory, PiecewisePolynomial
from scenario_plants import add_scene, arm_of

from soft_gripper.control.arm_motion import joint_path
from soft_gripper.control.task import Phase
from soft_gripper.diagrams import task_plan as path_check
from soft_gripper.diagrams.task_plan import POSTURE_SPACING, TOUCH_DEPTH, check_paths, first_collision
from soft_gripper.errors import InputError
from soft_gripper.scenario.schema import ModelConfig, PhaseConfig, PoseErrorConfig, TaskConfig

BALL, SMALL = 0.05, 0.006  # m, radii
AHEAD = 0.3  # m, from the ball on the slide to the thing in its grasp
WALL = 3.0  # m, where the wall begins
BEGIN, GOAL = -2.0, 2.0  # m, places of the thing on the slide
SLIDE = joint("prismatic", "base", "x", "1 0 0") + "<link name='x'/>" + joint("revolute", "x", "flange", "1 0 0")


def ball(name, radius):
    return f"""<robot name="{name}"><link name="{name}"><inertial><mass value="1"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><sphere radius="{radius}"/></geometry></collision></link></robot>"""


WALL_URDF = f"""<robot name="wall"><link name="wall"><collision><origin xyz="{WALL + 0.5} 0 0"/>
  <geometry><box size="1 1 1"/></geometry></collision></link></robot>"""


class Slide:
    """A ball as the gripper on a slide, a thing of the same radius, and a wall."""

    def __init__(self, folder, radius):
        self.scenario = small_arm(folder, SLIDE + "<link name='flange'/>", [0.0, 0.0])
        for name, text in (("hand", ball("hand", radius)), ("thing", ball("thing", radius)), ("wall", WALL_URDF)):
            (folder / f"{name}.urdf").write_text(text)
        self.thing = ModelConfig("thing", str(folder / "thing.urdf"), X_PC=at(BEGIN), free=True)
        self.scenario.models += [ModelConfig("wall", str(folder / "wall.urdf")), self.thing]
        self.scenario.task = TaskConfig("thing", X_OG=at(-AHEAD), X_WGoal=at(GOAL))
        builder = DiagramBuilder()
        scene = add_scene(builder, self.scenario)
        self.plant, self.scene_graph, self.arm = scene.plant, scene.scene_graph, arm_of(self.scenario, scene)
        self.diagram = builder.Build()

    def check(self, *phases, rescues=0):
        """Looks at phases, the last of which are rescues."""
        own = phases[: len(phases) - rescues]
        self.scenario.task.phases = [PhaseConfig(phase.name, holds=phase.holds) for phase in own]
        models, task = self.scenario.models, self.scenario.task
        check_paths(self.diagram, self.plant, self.scene_graph, models, self.arm, task, phases)

    def complaint(self, *phases, rescues=0):
        with pytest.raises(InputError) as caught:
            self.check(*phases, rescues=rescues)
        assert "\n" not in str(caught.value)
        return str(caught.value)


def at(x):
    return Transform(RigidTransform([x, 0, 0]))


def phase(name, start, end, holds=False):
    """The ball goes from x to x, m, slowly at both ends."""
    ease = PiecewisePolynomial.CubicHermite([0.0, 2.0], [[0.0, 1.0]], [[0.0, 0.0]])
    motion = PathParameterizedTrajectory(joint_path(np.array([start, 0.0]), np.array([end, 0.0])), ease)
    return Phase(name, motion, 0.05, 0, holds=holds)


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    return Slide(tmp_path_factory.mktemp("slide"), BALL)


def numbers(complaint):
    """How much of the way is gone, and how deep it is then, m."""
    found = re.search(r"(\d+)% along its path, .* is ([\d.]+) mm inside", complaint)
    return float(found[1]) / 100, float(found[2]) / 1e3


def test_the_phase_that_leads_into_something_is_named(slide):
    complaint = slide.complaint(phase("there", 0.0, 1.0), phase("into", 1.0, 3.5), phase("back", 3.5, 0.0))
    # The thing, at its begin, is not on the way.
    assert complaint.startswith("task.phases[1]: name = 'into': collides: ")
    assert "'hand::hand' is " in complaint
    assert complaint.endswith(" inside 'wall::wall'")
    part, depth = numbers(complaint)
    assert TOUCH_DEPTH < depth < TOUCH_DEPTH + 2 * POSTURE_SPACING
    assert part == pytest.approx((WALL - BALL + depth - 1.0) / 2.5, abs=0.02)


THROUGH_BEGIN, THROUGH_GOAL = (0.0, -2.5), (0.0, 2.5)


@pytest.mark.parametrize(
    ("held_before", "way", "holds", "meets"),
    [
        (False, THROUGH_BEGIN, False, True),
        (False, THROUGH_GOAL, False, False),
        (False, THROUGH_BEGIN, True, False),
        (False, THROUGH_GOAL, True, False),
        (True, THROUGH_BEGIN, False, False),
        (True, THROUGH_GOAL, False, True),
    ],
)
def test_where_the_thing_lies_before_and_after_it_is_held(slide, held_before, way, holds, meets):
    phases = (phase("before", 0.0, 0.0, holds=held_before), phase("through", *way, holds=holds))
    if not meets:
        slide.check(*phases)
        return
    complaint = slide.complaint(*phases)
    assert complaint.startswith("task.phases[1]: name = 'through': ")
    assert complaint.endswith("inside 'thing::thing'")


def test_the_thing_is_avoided_where_it_is_reported(slide):
    slide.scenario.task.pose_error = PoseErrorConfig(y=2 * BALL)
    slide.check(phase("through", *THROUGH_BEGIN))
    slide.scenario.task.pose_error = PoseErrorConfig(x=-BEGIN, y=2 * BALL - 4e-3)
    assert slide.complaint(phase("through", 0.0, 1.0)).endswith("inside 'thing::thing'")
    slide.scenario.task.pose_error = PoseErrorConfig()


@pytest.mark.parametrize("way", [THROUGH_BEGIN, THROUGH_GOAL])
@pytest.mark.parametrize("holds", [True, False])
def test_in_a_rescue_nobody_knows_where_the_thing_is(slide, way, holds):
    slide.check(phase("before", 0.0, 0.0, holds=holds), phase("rescue", *way), rescues=1)


def test_a_rescue_is_reported_with_the_phase_that_it_follows(slide):
    fine, watched = phase("before", 0.0, 0.0), replace(phase("watched", 0.0, 0.0), rescue=2)
    opened, risen = phase("rescue: open", 0.0, 0.0), phase("rescue: rise", 0.0, 0.0)
    complaint = slide.complaint(fine, watched, opened, risen, phase("rescue: home", 0.0, WALL), rescues=3)
    assert complaint.startswith("task.phases[1]: name = 'rescue: home': collides: ")


def test_something_thin_is_not_skipped(tmp_path):
    """The balls overlap by more than a touch along 22 mm, which is more than a step, wherever the thing lies."""
    slide = Slide(tmp_path, SMALL)
    assert 2 * (2 * SMALL - TOUCH_DEPTH) > POSTURE_SPACING
    skipped = []
    for x in np.linspace(0.5, 0.6, 41):
        slide.thing.X_PC = at(x)
        try:
            slide.check(phase("through", -3.5, 2.5))
        except InputError:
            continue
        skipped.append(x)
    assert skipped == []


@pytest.mark.parametrize("travel", [0.5, 3.0, 6.2])
def test_no_joint_moves_further_than_a_step_between_two_postures(slide, monkeypatch, travel):
    """The slide by a part of what the other joint turns."""
    seen = []
    monkeypatch.setattr(path_check, "first_collision", lambda *args: seen.append(args[-1]))
    way = joint_path(np.array([0.0, 0.0]), np.array([0.3 * travel, -travel]))
    ease = PiecewisePolynomial.CubicHermite([0.0, 2.0], [[0.0, 1.0]], [[0.0, 0.0]])
    slide.check(Phase("turn", PathParameterizedTrajectory(way, ease), 0.05, 0))
    context = slide.plant.CreateDefaultContext()
    arm, postures = slide.plant.GetModelInstanceByName("arm"), []
    for q in seen[0]:
        slide.plant.SetPositions(context, q)
        postures.append(slide.plant.GetPositions(context, arm))
    np.testing.assert_allclose(postures[0], [0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(postures[-1], [0.3 * travel, -travel], atol=1e-9)
    assert np.abs(np.diff(postures, axis=0)).max() <= POSTURE_SPACING * (1 + 1e-9)
    assert len(postures) <= 2 + travel / POSTURE_SPACING


# A sled, 0.2 m long, slides along x, through a post of the same robot; a ball of radius 50 mm floats freely; a wall
# begins at x = 1 m.
ROBOT = """<robot name="robot">
  <link name="rail"/>
  <link name="sled"><collision><geometry><box size="0.2 0.1 0.1"/></geometry></collision></link>
  <link name="post"><collision><geometry><box size="0.05 0.05 0.4"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="sled"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" velocity="1" effort="1"/></joint>
  <joint name="swivel" type="revolute"><parent link="rail"/><child link="post"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" velocity="1" effort="1"/></joint>
</robot>"""
WALL_MODEL = """<robot name="wall"><link name="wall"><collision><origin xyz="1.5 0 0"/>
  <geometry><box size="1 4 4"/></geometry></collision></link></robot>"""
BALL_MODEL = """<robot name="ball"><link name="ball"><inertial><mass value="1"/>
  <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><sphere radius="0.05"/></geometry></collision></link></robot>"""
ASIDE = [0, 2, 0]  # m, where the ball meets nothing


class Scene:
    """The robot among wall and ball."""

    def __init__(self):
        builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        for text in (ROBOT, WALL_MODEL, BALL_MODEL):
            Parser(self.plant).AddModelsFromString(text, "urdf")
        for name in ("rail", "wall"):
            self.plant.WeldFrames(self.plant.world_frame(), self.plant.GetFrameByName(name))
        self.plant.Finalize()
        self.diagram = builder.Build()

    def bodies(self, *names):
        return {self.plant.GetBodyByName(name).index() for name in names}

    def positions(self, sled, ball):
        """Of the plant, one for every position of the sled, with the ball at `ball` in the world."""
        context = self.plant.CreateDefaultContext()
        q = self.plant.GetPositions(context)
        self.plant.GetJointByName("slide").set_translation(context, 1.0)
        slide = np.flatnonzero(self.plant.GetPositions(context) - q)
        ball_at = self.plant.GetBodyByName("ball").floating_positions_start() + 4
        rows = np.tile(q, (len(sled), 1))
        rows[:, slide[0]], rows[:, ball_at : ball_at + 3] = sled, ball
        return rows

    def first(self, sled, ball=ASIDE, robot=("rail", "sled", "post")):
        positions = self.positions(sled, ball)
        root = self.diagram.CreateDefaultContext()
        return first_collision(root, self.plant, self.scene_graph, self.bodies(*robot), positions)


@pytest.fixture(scope="module")
def scene():
    return Scene()


def test_box_into_wall(scene):
    """The sled's nose is 0.1 m ahead of its middle."""
    collision = scene.first([0.5, 0.85, 0.9005, 0.92, 0.95])
    assert (collision.index, collision.body, collision.obstacle) == (3, "robot::sled", "wall::wall")
    assert collision.depth == pytest.approx(0.02, abs=1e-6)
    assert str(collision) == "'robot::sled' is 20.0 mm inside 'wall::wall'"


def test_a_touch_is_no_collision(scene):
    assert scene.first([0.9 + 0.9 * TOUCH_DEPTH]) is None
    assert scene.first([0.9 + 1.1 * TOUCH_DEPTH]).depth == pytest.approx(1.1 * TOUCH_DEPTH, abs=1e-6)


def test_carried_ball_belongs_to_the_robot(scene):
    robot, ball = ("rail", "sled", "post", "ball"), [0.97, 0, 0.08]
    collision = scene.first([0.88], ball, robot)
    assert (collision.body, collision.obstacle) == ("ball::ball", "wall::wall")
    assert collision.depth == pytest.approx(0.02, abs=1e-6)


@pytest.mark.parametrize(("height", "obstacle"), [(0.09, "wall::wall"), (0.06, "ball::ball")])
def test_deepest_comes_first(scene, height, obstacle):
    """The sled is 30 mm in the wall, the ball 10 or 40 mm in the sled."""
    assert scene.first([0.93], ball=[0.93, 0, height]).obstacle == obstacle
