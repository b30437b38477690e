"""An uneven object is touched on its own surface, waist and all, and not on its convex hull."""

import numpy as np
import pytest
import trimesh
from pydrake.geometry import HydroelasticContactRepresentation
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import ModelConfig

MESH = trimesh.load(DIRECTORY / "objects" / "irregular.obj", force="mesh")
NECK = 0.01875  # m above the foot, where the body is thinnest
RADIUS = 0.001  # m, of the probe
PROBE = f"""<sdf version="1.7"><model name="probe"><link name="probe"><collision name="ball">
  <geometry><sphere><radius>{RADIUS}</radius></sphere></geometry>
  <drake:proximity_properties xmlns:drake="http://drake.mit.edu">
    <drake:compliant_hydroelastic/>
    <drake:hydroelastic_modulus>1e5</drake:hydroelastic_modulus>
    <drake:mesh_resolution_hint>{RADIUS}</drake:mesh_resolution_hint>
  </drake:proximity_properties>
</collision></link></model></sdf>"""


def below_hull(point):
    """How deep a point lies in the convex hull of the mesh, m."""
    hull = MESH.convex_hull
    return -np.einsum("fi,fi->f", point - hull.triangles[:, 0], hull.face_normals).max()


def touches(query):
    """Contact surfaces, and the pairs for which contact at a point takes their place."""
    return query.ComputeContactSurfacesWithFallback(HydroelasticContactRepresentation.kTriangle)


@pytest.fixture(params=["irregular.sdf", "irregular.obj"])
def probe(request, tmp_path, monkeypatch):
    """Puts a small soft ball at a point beside the object, a model file or a bare mesh; returns what is touched."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    load_model(plant, ModelConfig("irregular", str(DIRECTORY / "objects" / request.param)), "models[0]")
    Parser(plant).AddModelsFromString(PROBE, "sdf")
    plant.Finalize()
    context = builder.Build().CreateDefaultContext()

    def put(point):
        plant_context = plant.GetMyMutableContextFromRoot(context)
        for name, position in (("irregular", np.zeros(3)), ("probe", point)):
            plant.SetFreeBodyPose(plant_context, plant.GetBodyByName(name), RigidTransform(position))
        return scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))

    return put


@pytest.fixture(scope="module")
def waist():
    """The innermost point of the waist, m, and the direction that leads out of it."""
    height = MESH.vertices[:, 2] - MESH.bounds[0, 2]
    near = MESH.vertices[np.abs(height - NECK) < 3e-3]
    point = near[np.argmin(np.hypot(near[:, 0], near[:, 1]))]
    return point, point * [1, 1, 0] / np.hypot(point[0], point[1])


def test_nothing_is_touched_between_the_waist_and_the_hull(probe, waist):
    point, outward = waist
    for gap in (0.0015, 0.003, 0.005):
        place = point + gap * outward
        query = probe(place)
        assert below_hull(place) > 2 * RADIUS
        assert touches(query) == ([], [])
        (hull_contact,) = query.ComputePointPairPenetration()
        assert hull_contact.depth > 3 * RADIUS


def test_the_waist_itself_is_touched(probe, waist):
    point, outward = waist
    for gap in (-0.0005, 0.0, 0.0005):
        (surface,), pairs = touches(probe(point + gap * outward))
        assert pairs == []
        assert np.linalg.norm(surface.centroid() - point) < RADIUS
        assert below_hull(surface.centroid()) > 0.007
