"""Soft objects: their deformation, scenarios with them, and the picture of those that are carried."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from refusals import refused
from scipy.spatial.transform import Rotation

from pictures.soft_grasps import OBJECTS, run_grasp
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import advance, run_to_end
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.extras import soft
from soft_gripper.extras.soft import soft_object as module
from soft_gripper.extras.soft.soft_object import fitted_pose, largest_strain, move_wrench, squeeze
from soft_gripper.extras.soft.tetrahedra import read_tetrahedra
from soft_gripper.runs.scores.recorded_grasps import recorded_grasps
from soft_gripper.scenario.scenario_file import load_scenario

SPONGE = "pick_and_place_sponge"


@pytest.mark.parametrize(
    ("override", "field", "value"),
    [
        ("plant_config.time_step=0", "time_step", 0),
        ("contact=points", "contact", "points"),
        ("models.2.half_space=true", "half_space", True),
        (f"models.3.file={'package://soft_gripper/objects/box.obj'}", "mesh.youngs_modulus", 2e4),
    ],
)
def test_what_does_not_go_with_a_soft_object_is_refused(override, field, value):
    with refused(field, value):
        make_station(load_scenario(SPONGE, [override]))


def test_other_approximations_of_contact_are_warned_of(caplog):
    make_station(load_scenario(SPONGE, ["plant_config.discrete_contact_approximation=lagged"]))
    assert "discrete_contact_approximation" in caplog.text


def test_a_crushed_object_is_an_error():
    station = make_station(load_scenario(SPONGE))
    simulator = Simulator(station.diagram)
    context = station.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    soft = station.parts.deformables["sponge"]
    soft.body.SetPositions(context, soft.rest.vertices.T * np.array([[1.0], [1.0], [-1.0]]))
    with pytest.raises(SimulationDivergedError, match="sponge"):
        advance(simulator, station, 1e-4)


@pytest.fixture(scope="module")
def lifted() -> tuple[Station, Recording]:
    """A sponge that has been lifted and held for a while, in long steps."""
    scenario = load_scenario(SPONGE, ["plant_config.time_step=0.01", "task.phases.3.rest=0.8"])
    phases = scenario.task.phases[:4]  # it is held at the end of the last of them
    station = make_station(replace(scenario, task=replace(scenario.task, phases=phases)))
    return station, station.recording(run_to_end(station).get_context())


@pytest.mark.slow
def test_a_lifted_sponge_is_held_by_forces_that_carry_it(lifted):
    station, recording = lifted
    (grasp,), grips = recorded_grasps(station, recording)
    assert grasp.grasp == "held"
    assert {grip.finger for grip in grips} == {"left_finger", "right_finger"}
    carried = recording["sponge.grip_force"].values[-30:].sum(axis=1).mean(axis=0)
    wrench = recording["sponge.contact_wrench"].values[-30:, 3:].mean(axis=0)
    np.testing.assert_allclose(carried, wrench, atol=1e-9)  # nothing else touches it
    assert wrench[2] == pytest.approx(0.016 * 9.81, rel=0.01)


SDF = """<sdf version="1.7"><model name="jelly"><link name="jelly">
  <collision name="elements"><geometry><mesh><uri>package://soft_objects/objects/soft_block.vtk</uri></mesh></geometry>
    <drake:proximity_properties xmlns:drake="http://drake.mit.edu"><drake:mu_dynamic>0.8</drake:mu_dynamic>
    </drake:proximity_properties></collision>
  <drake:deformable_properties xmlns:drake="http://drake.mit.edu"><drake:youngs_modulus>2e4</drake:youngs_modulus>
    <drake:poissons_ratio>0.3</drake:poissons_ratio><drake:mass_density>150</drake:mass_density>
  </drake:deformable_properties></link>{}</model></sdf>"""


def test_an_sdf_file_of_finite_elements_is_a_soft_object(tmp_path):
    (tmp_path / "jelly.sdf").write_text(SDF.format(""))
    station = make_station(load_scenario("box_grasp", [f"models.2.file={tmp_path / 'jelly.sdf'}"]))
    soft = station.parts.deformables["box"]
    assert soft.mass == pytest.approx(150 * 0.044 * 0.04 * 0.06)
    recorded = {f"box.{signal}" for signal in ("pose", "vertices", "squeeze", "largest_strain", "contact_wrench")}
    assert recorded <= set(station.logs.signals)


REST = read_tetrahedra(Path(soft.__path__[0]) / "objects" / "soft_block.vtk")  # 44 x 40 x 60 mm
TURNS = Rotation.from_rotvec([[0.0, 0.0, 0.0], [0.4, -1.1, 0.7], [0.0, 3.0, 0.0]])
PLACES = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 0.5], [1.0, 2.0, 3.0]])


def moved(vertices):
    """Each of three rigid motions of the same vertices, (3, V, 3) m."""
    return np.array([turn.apply(vertices) + place for turn, place in zip(TURNS, PLACES, strict=True)])


def test_a_rigid_motion_is_found_and_neither_squeezes_nor_strains():
    points = moved(REST.vertices)
    poses = fitted_pose(REST, points)
    np.testing.assert_allclose(poses[:, 4:], PLACES, atol=1e-12)
    np.testing.assert_allclose(poses[:, :4], TURNS.as_quat(canonical=True, scalar_first=True), atol=1e-9)
    np.testing.assert_allclose(squeeze(REST, points), 0, atol=1e-12)
    np.testing.assert_allclose(largest_strain(REST, points), 0, atol=1e-9)


def test_a_uniform_compression_squeezes_and_leaves_the_pose():
    """By 5 % along z: the edges along z shorten by 3 mm, and nothing shortens more."""
    points = moved(REST.vertices * [1.0, 1.0, 0.95])
    np.testing.assert_allclose(squeeze(REST, points), 0.05 * 0.060, rtol=1e-9)
    np.testing.assert_allclose(largest_strain(REST, points), 0.05, rtol=1e-9)
    poses = fitted_pose(REST, points)
    np.testing.assert_allclose(poses[:, 4:], PLACES, atol=1e-9)
    np.testing.assert_allclose(poses[:, :4], TURNS.as_quat(canonical=True, scalar_first=True), atol=1e-6)


def test_a_stretch_strains_and_hardly_squeezes():
    points = REST.vertices * [1.0, 1.2, 1.0]
    assert largest_strain(REST, points) == pytest.approx(0.2)
    assert squeeze(REST, points) == pytest.approx(0, abs=1e-12)


def test_simple_shear_has_the_principal_stretches_of_the_textbook():
    """Of a shear g, the stretches are sqrt(1 + g^2/4) +- g/2, of which the larger is further from 1."""
    g = 0.3
    sheared = REST.vertices @ (np.eye(3) + g * np.outer([0, 1, 0], [1, 0, 0]))
    assert largest_strain(REST, sheared) == pytest.approx(np.sqrt(1 + g**2 / 4) + g / 2 - 1)


def test_a_wrench_is_moved_to_the_object():
    """A force that acts at the object's position has a torque about the origin, and none about the object."""
    place, force = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -3.0])
    pose = np.array([1.0, 0, 0, 0, *place])
    wrench = np.array([*(np.cross(place, force) + np.array([0, 0, 0.7])), *force])
    np.testing.assert_allclose(move_wrench(wrench, pose), [0, 0, 0.7, *force], atol=1e-12)


def test_a_contact_has_its_torque_about_the_origin_whichever_of_both_bodies_comes_first(monkeypatch):
    """That of the patch about its own place, and of its force there; forces on the other body count the other way."""
    rng = np.random.default_rng(4)
    torque, place, force = rng.normal(size=(3, 3))
    expected = np.append(torque + np.cross(place, force), force)
    block = SimpleNamespace(_geometry=7, _results=SimpleNamespace(Eval=lambda context: None))
    for geometries, sign in (((7, 3), 1.0), ((3, 7), -1.0)):
        patch = SimpleNamespace(geometries=geometries, torque=torque, place=place, force=force)
        monkeypatch.setattr(module, "patches", lambda results, own, patch=patch: [patch, patch])
        np.testing.assert_allclose(module.SoftObject._wrench(block, None), 2 * sign * expected)


PAGE = (Path(__file__).parents[3] / "docs/extras/soft/soft_objects.md").read_text(encoding="utf-8")


@pytest.mark.published
@pytest.mark.parametrize("name", OBJECTS[:2])
def test_numbers_of_the_page(name: str) -> None:
    (printed,) = re.findall(rf"^\| {name} \| [^|]* \| (.*) \|$", PAGE, re.MULTILINE)
    grasp = run_grasp(name)
    result = grasp.result
    found = (result.peak_force_n, result.squeeze_mm, 100 * grasp.strain.max(), result.slip_mm, result.placed_error_mm)
    np.testing.assert_allclose(found, [float(number) for number in printed.split("|")], atol=0.06)
