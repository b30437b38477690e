"""Whether a robot runs into anything on its way."""

from collections.abc import Collection
from dataclasses import dataclass

from pydrake.geometry import PenetrationAsPointPair, SceneGraph, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Diagram

from soft_gripper.arrays import Array

TOUCH_DEPTH = 1e-3  # m, depth of a touch


@dataclass(frozen=True)
class Collision:
    """A body of the robot inside something that is not of the robot."""

    index: int  # of the positions in which it happens
    body: str  # of the robot; names are model::body
    obstacle: str
    depth: float  # m

    def __str__(self) -> str:
        return f"'{self.body}' is {self.depth * 1e3:.1f} mm inside '{self.obstacle}'"


def first_collision(
    diagram: Diagram,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: Collection[BodyIndex],
    positions: Array,
    allowed: float = TOUCH_DEPTH,
) -> Collision | None:
    """Walks through positions of the whole plant, (K, nq), until the robot meets something.

    Meshes count as their convex hulls. What is welded to the same body, and what a model filters, never collides.

    Args:
        diagram: holds plant and scene_graph.
        plant: the plant.
        scene_graph: its geometry.
        robot: its bodies, what it carries among them; they may touch each other.
        positions: rad and m; no finer steps are looked at.
        allowed: depth that passes for a touch, m.

    Returns:
        The deepest collision of the first positions that have one.
    """
    root = diagram.CreateDefaultContext()
    context, scene_context = plant.GetMyMutableContextFromRoot(root), scene_graph.GetMyContextFromRoot(root)
    own = frozenset(robot)
    for index, q in enumerate(positions):
        plant.SetPositions(context, q)
        query = scene_graph.get_query_output_port().Eval(scene_context)
        for pair in sorted(query.ComputePointPairPenetration(), key=lambda pair: -pair.depth):
            bodies = _bodies(plant, query.inspector(), pair)
            if pair.depth > allowed and len(bodies & own) == 1:
                (body,), (obstacle,) = bodies & own, bodies - own
                return Collision(index, _name(plant, body), _name(plant, obstacle), pair.depth)
    return None


def _bodies(
    plant: MultibodyPlant, inspector: SceneGraphInspector, pair: PenetrationAsPointPair
) -> frozenset[BodyIndex]:
    frames = [inspector.GetFrameId(geometry) for geometry in (pair.id_A, pair.id_B)]
    return frozenset(plant.GetBodyFromFrameId(frame).index() for frame in frames)


def _name(plant: MultibodyPlant, body: BodyIndex) -> str:
    return str(plant.get_body(body).scoped_name())
