"""From where a scene is seen: before the arm, from aside; as near as the edges of the picture let; all of it."""

from itertools import product

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.geometry import Role
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.meshcat_view import box_corners, nearest_eye, upright_view, viewing_direction
from soft_gripper.scenario.scenario_file import load_scenario

ALONE = np.array([0.2, 1.0, -0.2])


def direction_of(name: str, arm_yaw: float = 0.0, shift: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Array:
    """Into the scene of a scenario, whose arm stands elsewhere."""
    scenario = load_scenario(name)
    if scenario.arm is not None:
        scenario.models[0].X_PC = Transform(RigidTransform(RotationMatrix.MakeZRotation(arm_yaw), shift))
    plant, _, fingers, *_ = add_scene(DiagramBuilder(), scenario)
    return viewing_direction(scenario.arm, plant, fingers, ALONE)


def test_an_arm_is_seen_from_before_it_from_its_right_and_from_above() -> None:
    ahead, left, up = -direction_of("pick_and_place_box")  # the arm stands at the origin and reaches toward +x
    assert ahead > 0.3
    assert left < -0.3
    assert up > 0.2


def test_an_upright_view_looks_along_its_z_with_the_world_upright() -> None:
    view = upright_view(np.array([-1.0, 2.0, -0.7])).matrix()
    np.testing.assert_allclose(np.cross(view[:, 0], view[:, 1]), view[:, 2], atol=1e-15)
    np.testing.assert_allclose(view[:, 2], np.array([-1.0, 2.0, -0.7]) / np.linalg.norm([1.0, 2.0, 0.7]))
    assert view[2, 0] == 0
    assert view[2, 1] < 0


@pytest.mark.parametrize(
    ("least", "most"), [((-0.2, -0.2), (0.2, 0.2)), ((-0.5, -0.3), (0.5, 0.1)), ((-0.1, -0.4), (0.3, 0.4))], ids=str
)
def test_the_nearest_eye_sees_all_and_cannot_come_nearer(least: tuple[float, ...], most: tuple[float, ...]) -> None:
    points = np.random.default_rng(3).uniform([-0.2, -0.3, 0.0], [0.3, 0.1, 0.5], (100, 3))
    view = upright_view(np.array([0.3, 1.0, -0.4]))

    def slopes(eye: Array) -> Array:
        along = (points - eye) @ view.matrix()
        assert np.all(along[:, 2] > 0)
        return along[:, :2] / along[:, 2:]

    eye = nearest_eye(points, view, np.array(least), np.array(most))
    seen = slopes(eye)
    assert np.all((seen > np.array(least) - 1e-12) & (seen < np.array(most) + 1e-12))
    nearer = eye + view.matrix() @ [0.0, 0.0, 1e-3]
    for aside in product(np.linspace(-0.05, 0.05, 11), repeat=2):
        seen = slopes(nearer + view.matrix()[:, :2] @ aside)
        assert np.any((seen < least) | (seen > most))


def test_boxes_are_where_drake_has_them() -> None:
    builder = DiagramBuilder()
    plant, scene_graph, fingers, *_ = add_scene(builder, load_scenario("pick_and_place_box"))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    box = plant.GetModelInstanceByName("box")
    X_WBox = RigidTransform(RollPitchYaw(0.3, -0.2, 0.9), [0.1, 0.2, 0.3])
    plant.SetFreeBodyPose(plant_context, plant.GetBodyByName("box"), X_WBox)
    corners = box_corners(plant, scene_graph, plant_context, [box], Role.kPerception)
    halves = np.abs(X_WBox.inverse() @ corners.T).T
    np.testing.assert_allclose(halves, np.tile(halves[0], (8, 1)), atol=1e-9)
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    models = [plant.GetModelInstanceByName("arm"), fingers[0].model]
    inspector = scene_graph.model_inspector()
    centers = [
        query.ComputeObbInWorld(shape).pose().translation()
        for model in models
        for body in plant.GetBodyIndices(model)
        for shape in inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body), Role.kPerception)
    ]
    corners = box_corners(plant, scene_graph, plant_context, models, Role.kPerception)
    np.testing.assert_allclose(corners.reshape(-1, 8, 3).mean(axis=1), centers, atol=1e-9)
