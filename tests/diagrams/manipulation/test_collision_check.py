"""A robot that runs into something, with depths from geometry."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.task_plan import first_collision

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
WALL = """<robot name="wall"><link name="wall"><collision><origin xyz="1.5 0 0"/>
  <geometry><box size="1 4 4"/></geometry></collision></link></robot>"""
BALL = """<robot name="ball"><link name="ball"><inertial><mass value="1"/>
  <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><sphere radius="0.05"/></geometry></collision></link></robot>"""
ASIDE = [0, 2, 0]  # m, where the ball meets nothing


class Scene:
    """The robot among wall and ball."""

    def __init__(self):
        builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        for text in (ROBOT, WALL, BALL):
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

    def first(self, sled, ball=ASIDE, robot=("rail", "sled", "post"), **options):
        positions = self.positions(sled, ball)
        root = self.diagram.CreateDefaultContext()
        return first_collision(root, self.plant, self.scene_graph, self.bodies(*robot), positions, **options)


@pytest.fixture(scope="module")
def scene():
    return Scene()


def test_box_into_wall(scene):
    """The sled's nose is 0.1 m ahead of its middle."""
    collision = scene.first([0.5, 0.85, 0.9005, 0.92, 0.95])
    assert (collision.index, collision.body, collision.obstacle) == (3, "robot::sled", "wall::wall")
    assert collision.depth == pytest.approx(0.02, abs=1e-6)
    assert str(collision) == "'robot::sled' is 20.0 mm inside 'wall::wall'"


def test_touch_is_as_deep_as_allowed(scene):
    assert scene.first([0.92], allowed=0.021) is None
    assert scene.first([0.92], allowed=0.019).depth == pytest.approx(0.02, abs=1e-6)


def test_carried_ball_belongs_to_the_robot(scene):
    robot, ball = ("rail", "sled", "post", "ball"), [0.97, 0, 0.08]
    collision = scene.first([0.88], ball, robot)
    assert (collision.body, collision.obstacle) == ("ball::ball", "wall::wall")
    assert collision.depth == pytest.approx(0.02, abs=1e-6)


@pytest.mark.parametrize(("height", "obstacle"), [(0.09, "wall::wall"), (0.06, "ball::ball")])
def test_deepest_comes_first(scene, height, obstacle):
    """The sled is 30 mm in the wall, the ball 10 or 40 mm in the sled."""
    assert scene.first([0.93], ball=[0.93, 0, height]).obstacle == obstacle
