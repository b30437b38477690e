"""Meshes of objects are touched at their surface, whatever the format of their file; those of arms at their hull."""

import numpy as np
import pytest
import trimesh
from pydrake.geometry import AddCompliantHydroelasticProperties, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.scene import add_model
from soft_gripper.files.notes import collect_notes
from soft_gripper.scenario.schema import ArmConfig, ModelConfig

PROPERTIES = "<drake:proximity_properties>{}</drake:proximity_properties>"
RADIUS = 0.008  # m, of a ball that fits between the tines of the fork


@pytest.fixture(autouse=True)
def _files(cache):
    fork().export("fork.obj")
    (inverted := fork()).invert()
    inverted.export("inverted.stl")
    (opened := fork()).update_faces(np.arange(len(opened.faces)) > 0)
    opened.export("opened.obj")
    trimesh.creation.box([0.06, 0.02, 0.1]).export("block.obj")


def fork():
    """Two tines, 20 mm thick and as far apart: their hull is 1.5 times as large."""
    return trimesh.util.concatenate(
        [tine.apply_translation([x, 0, 0]) for x, tine in ((-0.02, a_tine()), (0.02, a_tine()))]
    )


def a_tine():
    return trimesh.creation.box([0.02, 0.02, 0.1])


def urdf(mesh="fork.obj", scale="1 1 1", tags="", shape=""):
    geometry = f"<geometry><mesh filename='{mesh}' scale='{scale}'>{shape}</mesh></geometry>"
    inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    return f"""<robot name='m' xmlns:drake='http://drake.mit.edu'><link name='tines'>{inertial}
    <collision>{geometry}{tags}</collision></link></robot>"""


def sdf(mesh="fork.obj", scale="1 1 1", tags="", shape=""):
    geometry = f"<geometry><mesh><uri>{mesh}</uri><scale>{scale}</scale>{shape}</mesh></geometry>"
    return f"""<sdf version='1.7' xmlns:drake='http://drake.mit.edu'><model name='m'><link name='tines'>
    <collision name='c'>{geometry}{tags}</collision></link></model></sdf>"""


def mjcf(mesh="fork.obj", scale="1 1 1"):
    return f"""<mujoco model='m'><asset><mesh name='f' file='{mesh}' scale='{scale}'/></asset><worldbody>
    <body name='tines'><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><geom type='mesh' mesh='f'/>
    </body></worldbody></mujoco>"""


SUFFIXES = {urdf: "urdf", sdf: "sdf", mjcf: "xml"}


def contacts(text, suffix, ball):
    """How many surfaces and points a compliant ball has in common with a free model."""
    with open(f"m.{suffix}", "w") as file:
        file.write(text)
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    add_model(plant, ModelConfig("thing", f"m.{suffix}", free=True), "models[0]", None)
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(RADIUS, 1e5, properties)
    properties.AddProperty("material", "coulomb_friction", CoulombFriction(0.5, 0.5))
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(ball), Sphere(RADIUS), "ball", properties)
    plant.Finalize()
    diagram = builder.Build()
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(diagram.CreateDefaultContext()))
    return tuple(map(len, query.ComputeContactSurfacesWithFallback(plant.get_contact_surface_representation())))


BETWEEN, ON_A_TINE = [0.0, 0.0, 0.0], [0.035, 0.0, 0.0]


@pytest.mark.parametrize("form", SUFFIXES)
def test_what_is_convex_stays_as_it_is(form):
    assert contacts(form("block.obj"), SUFFIXES[form], BETWEEN) == (0, 1)


@pytest.mark.parametrize("form", [urdf, sdf])
def test_tags_of_drake_are_obeyed(form):
    friction = PROPERTIES.format(
        "<drake:mu_static value='0.4'/>" if form is urdf else "<drake:mu_static>0.4</drake:mu_static>"
    )
    assert contacts(form(tags=friction), SUFFIXES[form], BETWEEN) == (0, 0)
    assert contacts(form(shape="<drake:declare_convex/>"), SUFFIXES[form], BETWEEN) == (0, 1)


HULLS = "a link of an arm is touched at its convex hull, whose volume is 1.5 times that of the mesh"


@pytest.mark.parametrize("form", SUFFIXES)
@pytest.mark.parametrize(("mesh", "is_larger"), [("fork.obj", True), ("inverted.stl", True), ("block.obj", False)])
def test_how_much_larger_hulls_of_arms_are_is_noted(form, mesh, is_larger):
    with open(f"m.{SUFFIXES[form]}", "w") as file:
        file.write(form(mesh).replace("<freejoint/>", ""))
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    with collect_notes() as notes:
        add_model(plant, ModelConfig("arm", file.name), "models[0]", ArmConfig())
    expected = [("link 'tines': mesh", mesh)] if is_larger else []
    assert [(note.element, note.value) for note in notes if note.why == HULLS] == expected
