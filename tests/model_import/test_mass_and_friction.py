"""Mass and friction of models, given by a scenario: of files of every kind, in Drake's plant, and on a slope."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Role
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from refusals import refused
from scenario_plants import add_scene, scenario_of

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import ModelConfig

BOX = "package://soft_gripper/objects/box.sdf"
LINK = """<link name="{0}"><inertial><origin xyz="0.01 0 {1}"/><mass value="{1}"/>
<inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0.001" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="1 1 1"/></geometry></collision>
<collision><geometry><sphere radius="1"/></geometry></collision></link>"""
HINGE = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>'
MJCF = """<mujoco model="lever"><default><geom density="300"/>
<default class="heavy"><geom mass="2" friction="0.1"/></default></default>
<worldbody><geom type="box" size="1 1 1"/><body name="a"><geom type="box" size="1 0.2 0.1" pos="0.3 0 0"/>
<body name="b"><joint axis="0 0 1"/><geom class="heavy" type="sphere" size="0.1"/>
<geom type="sphere" size="0.2"/></body>
<body name="c"><joint axis="0 1 0"/><inertial pos="0 0 1" mass="3" diaginertia="1 2 2.5"/></body>
<body name="d"><joint axis="0 1 0"/><inertial pos="0 0 1" mass="3" fullinertia="1 2 2.5 1e-13 0.1 0"/></body></body>
</worldbody></mujoco>"""
AUTO = """<sdf version="1.11"><model name="m"><link name="m"><inertial auto="true"/><collision name="c">{0}<geometry>
<box><size>0.1 0.1 0.02</size></box></geometry><drake:proximity_properties xmlns:drake="http://drake.mit.edu">
<drake:rigid_hydroelastic/></drake:proximity_properties></collision></link></model></sdf>"""
NO_INERTIA = '<sdf version="1.7"><model name="m"><link name="m"/></model></sdf>'
FILES = {
    "two_links.urdf": f'<robot name="r">{LINK.format("a", 0.5)}{LINK.format("b", 0.2)}{HINGE}</robot>',
    "lever.xml": MJCF,
    "auto.sdf": AUTO.format(""),
    "dense.sdf": AUTO.format("<density>700</density>"),
    "no_inertia.sdf": NO_INERTIA,
}


@pytest.fixture(autouse=True)
def _files(cache):
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    trimesh.creation.box([0.04, 0.03, 0.05]).export("mesh.obj")


def loaded(file: str, **changes: float):
    """A finalized plant with a model, the inspector of its scene, and the links of the model."""
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    model = load_model(plant, ModelConfig("model", file, **changes), "models[0]").model
    plant.Finalize()
    return plant, scene_graph.model_inspector(), [plant.get_body(i) for i in plant.GetBodyIndices(model)]


@pytest.mark.parametrize("file", [BOX, "package://soft_gripper/arms/ur5e.urdf", "mesh.obj", *FILES])
def test_the_mass_is_that_of_all_links_whose_inertias_change_in_proportion(file):
    *_, before = loaded(file)
    *_, after = loaded(file, mass=0.7)
    assert sum(body.default_mass() for body in after) == pytest.approx(0.7, rel=1e-9)
    factor = 0.7 / sum(body.default_mass() for body in before)
    for one, other in zip(before, after, strict=True):
        expected = factor * one.default_spatial_inertia().CopyToFullMatrix6()
        np.testing.assert_allclose(
            other.default_spatial_inertia().CopyToFullMatrix6(), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max()
        )


def frictions(inspector) -> set[tuple[float, float]]:
    """The different frictions of all collision geometries, static and dynamic."""
    properties = map(inspector.GetProximityProperties, inspector.GetAllGeometryIds(Role.kProximity))
    found = [each.GetProperty("material", "coulomb_friction") for each in properties]
    return {(each.static_friction(), each.dynamic_friction()) for each in found}


@pytest.mark.parametrize("file", [BOX, "mesh.obj", "two_links.urdf", "lever.xml", "auto.sdf"])
def test_the_friction_is_that_of_all_shapes(file):
    _, before, _ = loaded(file)
    _, after, _ = loaded(file, friction=0.23)
    assert frictions(after) == {(0.23, 0.23)}
    assert frictions(before).isdisjoint(frictions(after))
    assert before.NumGeometriesWithRole(Role.kProximity) == after.NumGeometriesWithRole(Role.kProximity)


def test_other_properties_and_other_models_keep_theirs():
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    Parser(plant).AddModels(str(DIRECTORY / "objects" / "table.sdf"))
    load_model(plant, ModelConfig("box", BOX, friction=0.23), "models[0]")
    found = frictions(scene_graph.model_inspector())
    assert len(found) == 2
    assert (0.23, 0.23) in found
    (box,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("box"))
    properties = scene_graph.model_inspector().GetProximityProperties(box)
    assert properties.GetProperty("material", "hunt_crossley_dissipation") == 2.0
    assert properties.HasProperty("hydroelastic", "compliance_type")


@pytest.mark.parametrize(("share", "slides"), [(0.9, False), (1.1, True)])
def test_a_slab_slides_on_a_slope_that_is_steeper_than_its_friction_angle(tmp_path, share, slides):
    """It is accelerated by g (sin a - mu cos a)."""
    friction, seconds, g = 0.3, 0.5, 9.81
    angle = share * np.arctan(friction)
    given = f"friction: {friction}"
    scenario = scenario_of(
        tmp_path,
        f"name: table, file: 'package://soft_gripper/objects/table.sdf', child: surface, {given}",
        f"name: box, file: auto.sdf, free: true, X_PC: {{translation: [0, 0, 0.01]}}, mass: 0.3, {given}",
    )
    scenario.gravity, scenario.plant_config.time_step = [g * np.sin(angle), 0.0, -g * np.cos(angle)], 1e-3
    builder = DiagramBuilder()
    plant = add_scene(builder, scenario).plant
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(seconds)
    pose = plant.GetBodyByName("m").EvalPoseInWorld(plant.GetMyContextFromRoot(simulator.get_context()))
    acceleration = g * (np.sin(angle) - friction * np.cos(angle)) if slides else 0.0
    assert pose.translation()[0] == pytest.approx(acceleration * seconds**2 / 2, rel=0.05, abs=1e-3)


@pytest.mark.parametrize("key", ["mass", "friction"])
def test_what_has_no_rigid_link_or_shape_has_none_to_change(key):
    Path("nothing.urdf").write_text('<robot name="r"><link name="a"/></robot>', encoding="utf-8")
    with refused(key, 0.5):
        loaded("nothing.urdf", **{key: 0.5})
