"""What the shipped objects are: masses, sizes and frictions, on which every shipped result depends."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Box, Cylinder, Mesh, Role, Shape
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import ModelConfig

FIXED = None  # has no mass that matters
# File, mass [kg], size [mm] (of a cylinder its diameter and length), and friction of a model of a scenario.
OBJECTS = {
    ("obstructed_inside", "peg"): ("peg.sdf", FIXED, (20, 60), 0.3),
    ("obstructed_outside", "peg"): ("peg.sdf", FIXED, (20, 60), 0.3),
    ("box_grasp", "table"): ("table.sdf", FIXED, (500, 360, 40), 0.5),
    ("box_grasp", "box"): ("box.sdf", 0.05, (44, 40, 60), 0.8),
    ("bottle_grasp", "bottle"): ("bottle.obj", 0.06, (44, 44, 120), 0.8),
    ("irregular_grasp", "irregular"): ("irregular.sdf", 0.06, (68.3, 66.9, 115.1), 0.8),
    ("three_finger_grasp", "apple"): ("apple.obj", 0.06, (59.9, 59.8, 57.9), 0.8),
    ("pick_and_place_box", "workbench"): ("workbench.sdf", FIXED, (900, 900, 40), 0.5),
    ("pick_and_place_box", "box"): ("box.obj", 0.05, (44, 40, 60), 0.8),
    ("pick_and_place_irregular", "irregular"): ("irregular.obj", 0.04, (54.7, 53.5, 92.1), 0.8),  # at a scale of 0.8
    ("pick_and_place_delicate", "cup"): ("cup.obj", 0.03, (46, 46, 65), 0.8),
    ("pick_and_place_apple", "apple"): ("apple.obj", 0.06, (59.9, 59.8, 57.9), 0.8),
}
OF_RECOGNITION = {"sphere.obj": (46, 46, 46), "cylinder.obj": (46, 46, 32)}  # grasped beside box and irregular

TO_LEARN_WITH = "rounded_block.sdf"


def size(shape: Shape) -> list[float]:
    """Size of a shape, m."""
    if isinstance(shape, Box):
        return list(shape.size())
    if isinstance(shape, Cylinder):
        return [2 * shape.radius(), shape.length()]
    assert isinstance(shape, Mesh)
    return list(shape.scale() * trimesh.load_mesh(shape.source().path()).extents)


@pytest.mark.parametrize(("where", "expected"), OBJECTS.items(), ids=map(" ".join, OBJECTS))
def test_an_object_is_as_shipped(
    where: tuple[str, str], expected: tuple[str, float | None, tuple[float], float]
) -> None:
    scenario, name = where
    file, mass, millimetres, friction = expected
    config = next(model for model in load_scenario(scenario).models if model.name == name)
    assert Path(config.file).name == file
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    model, *_ = load_model(plant, config, "models[0]")
    plant.Finalize()
    (body,) = (plant.get_body(index) for index in plant.GetBodyIndices(model))
    (geometry,) = plant.GetCollisionGeometriesForBody(body)
    inspector = scene_graph.model_inspector()
    material = inspector.GetProximityProperties(geometry).GetProperty("material", "coulomb_friction")
    assert (material.static_friction(), material.dynamic_friction()) == (friction, friction)
    assert config.free == (mass is not FIXED)
    assert mass is FIXED or body.default_mass() == pytest.approx(mass)
    looks = inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()), Role.kIllustration)
    for shape in map(inspector.GetShape, (geometry, *looks)):
        assert [1e3 * side for side in size(shape)] == pytest.approx(millimetres, abs=0.05)


def test_all_shipped_objects_are_in_the_table() -> None:
    shipped = {path.name for path in (DIRECTORY / "objects").iterdir() if path.suffix in (".sdf", ".obj")}
    assert shipped == {file for file, *_ in OBJECTS.values()} | set(OF_RECOGNITION) | {TO_LEARN_WITH}


def test_the_block_to_learn_with_is_as_shipped() -> None:
    """Its rods reach as far as a box of 44 x 28 x 60 mm, of which it has the inertia."""
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    model, *_ = load_model(plant, ModelConfig("block", f"package://soft_gripper/objects/{TO_LEARN_WITH}"), "models[0]")
    plant.Finalize()
    (body,) = (plant.get_body(index) for index in plant.GetBodyIndices(model))
    inspector, reaches = scene_graph.model_inspector(), []
    for geometry in plant.GetCollisionGeometriesForBody(body):
        rod, place = inspector.GetShape(geometry), inspector.GetPoseInFrame(geometry).translation()
        reaches.append(np.abs(place) + rod.radius() + np.array([0, 0, rod.length() / 2]))
        material = inspector.GetProximityProperties(geometry).GetProperty("material", "coulomb_friction")
        assert (material.static_friction(), material.dynamic_friction()) == (0.7, 0.7)
    extents = 2 * np.max(reaches, axis=0)
    np.testing.assert_allclose(extents, [0.044, 0.028, 0.060], atol=1e-12)
    assert body.default_mass() == 0.04
    moments = body.default_spatial_inertia().CalcRotationalInertia().get_moments()
    np.testing.assert_allclose(moments, 0.04 / 12 * (np.sum(extents**2) - extents**2), rtol=1e-4)
