"""Point contact of fingers, compared with contact over their surface and with the plant's own forces."""

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Mesh, Role
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.model_import.mesh_files import convex_parts
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

MASS, G = 0.05, 9.81  # kg of the box, m/s^2
STEPS = "pressure.steps.all=[50.0e3, 120.0e3]"


@pytest.fixture(scope="module")
def grasps():
    """The box grasp over the surface of the fingers, and at points of it."""
    points = {count: ["contact=points", f"contact_points={count}"] for count in (2, 4, 8)}
    return {kind: simulate(load_scenario("box_grasp", [STEPS, *more])) for kind, more in {0: [], **points}.items()}


def last(recording, signal):
    return recording[signal].values[-1]


@pytest.mark.parametrize("count", [2, 4, 8])
def test_tip_and_force_are_those_of_the_surface(grasps, count):
    for finger in ("left_finger", "right_finger"):
        tip, force = (f"{finger}.{signal}" for signal in ("true_tip_position", "true_contact_force"))
        np.testing.assert_allclose(last(grasps[count], tip), last(grasps[0], tip), atol=0.1e-3)
        assert last(grasps[count], force).item() == pytest.approx(last(grasps[0], force).item(), rel=0.003)


def test_creep_times_points_is_constant(grasps):
    """Every point slides in proportion to its own share of the force."""
    creep = {count: np.ptp(run["box.pose"].values[-100:, 6]) for count, run in grasps.items()}
    assert creep[2] / creep[4] == pytest.approx(2, rel=0.05)
    assert creep[4] / creep[8] == pytest.approx(2, rel=0.05)
    assert creep[4] <= 0.1e-3


def test_forces_are_in_balance(grasps):
    """At rest, the fingers press equally, and contact carries the weight of the box."""
    run = grasps[4]
    left, right = (last(run, f"{side}_finger.true_contact_force").item() for side in ("left", "right"))
    assert left == pytest.approx(right, rel=1e-3)
    assert last(run, "box.contact_wrench")[5] == pytest.approx(MASS * G, rel=1e-3)


def test_a_mesh_is_touched_at_its_convex_parts():
    scenario = load_scenario("irregular_grasp", ["contact=points", "contact_points=2"])
    plant, scene_graph, fingers, *_ = add_plant(DiagramBuilder(), scenario)
    inspector = scene_graph.model_inspector()
    skins = {each for finger in fingers for link in finger.links for each in plant.GetCollisionGeometriesForBody(link)}
    names = {each: inspector.GetName(each) for each in inspector.GetAllGeometryIds(Role.kProximity)}
    parts = {each for each, name in names.items() if "_part_" in name}
    assert len(parts) == 4  # below its widest place; the rest is convex
    for pair in inspector.GetCollisionCandidates():
        if parts & {*pair}:
            assert len(skins & {*pair}) == 1, "fingers alone touch the parts"
    touched = {each for pair in inspector.GetCollisionCandidates() if skins & {*pair} for each in pair} - skins
    assert not any(isinstance(inspector.GetShape(each), Mesh) for each in touched)


def parts_of(mesh, tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text(trimesh.exchange.obj.export_obj(mesh))
    return convex_parts(path, path.stat().st_mtime_ns)


def test_parts_of_a_cone_on_a_cone_fill_it(tmp_path):
    """Two cones tip to tip: the slices across their axis are convex, so that the parts fill it."""
    cone = trimesh.creation.cone(1.0, 1.0, sections=64)
    upper = cone.copy()
    upper.apply_transform(trimesh.transformations.rotation_matrix(np.pi, [1, 0, 0]))
    upper.apply_translation([0, 0, 2])
    both = trimesh.util.concatenate([cone, upper])
    hulls = [trimesh.convex.convex_hull(corners) for corners in parts_of(both, tmp_path)]
    assert sum(hull.volume for hull in hulls) == pytest.approx(2 * cone.volume, rel=1e-6)
    assert all(hull.bounds[0, 2] >= -1e-9 and hull.bounds[1, 2] <= 2 + 1e-9 for hull in hulls)


def test_the_shipped_irregular_object_is_followed_closely():
    path = DIRECTORY / "objects" / "irregular.obj"
    volume = sum(trimesh.convex.convex_hull(part).volume for part in convex_parts(path, 0))
    mesh = trimesh.load(path, force="mesh")
    assert volume == pytest.approx(mesh.volume, rel=0.02)
    assert mesh.convex_hull.volume > 1.05 * mesh.volume
