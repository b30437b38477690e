"""Links of fingers that nothing can ever touch have no collision geometry, all others keep theirs."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene, scenario_of

FINGER, PEG = (f"package://soft_gripper/{file}" for file in ("grippers/finger.urdf", "objects/peg.sdf"))
BOX = "package://soft_gripper/objects/box.sdf"
ALL = [*range(13)]


def facing(apart):
    """Two fingers whose inner sides face each other, m apart."""
    turned = f"X_PC: {{translation: [{apart}, 0, 0], rotation: !Rpy {{ deg: [0, 0, 180] }} }}"
    return [f"name: left, file: '{FINGER}'", f"name: right, file: '{FINGER}', {turned}"]


def free_box(x):
    return f"name: box, file: '{BOX}', free: true, X_PC: {{translation: [{x}, 0, 0]}}"


def skins(scenario):
    """The links with collision geometry, of every finger."""
    plant, scene_graph, fingers, *_ = add_scene(DiagramBuilder(), scenario)
    inspector = scene_graph.model_inspector()
    frames = [[plant.GetBodyFrameIdOrThrow(link.index()) for link in finger.links] for finger in fingers]
    return [[i for i in ALL if inspector.GetGeometries(of_finger[i], Role.kProximity)] for of_finger in frames]


def touched(scenario, *angles):
    """The links in contact in a scene with all skins, of every finger, whose first joint is at an angle, rad."""
    builder = DiagramBuilder()
    plant, scene_graph, fingers, *_ = add_scene(builder, scenario)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    for finger, angle in zip(fingers, angles, strict=True):
        finger.joints[0].set_angle(context, angle)
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(root))
    pairs = query.ComputePointPairPenetration()
    geometries = {geometry for pair in pairs for geometry in (pair.id_A, pair.id_B)}
    links = [[plant.GetCollisionGeometriesForBody(link)[0] for link in finger.links] for finger in fingers]
    return [[i for i in ALL if of_finger[i] in geometries] for of_finger in links]


@pytest.mark.parametrize("apart", [0.1, 0.22])
def test_links_that_meet_where_fingers_point_at_each_other_have_skins(tmp_path, apart):
    kept = skins(scenario_of(tmp_path, *facing(apart)))
    met = touched(scenario_of(tmp_path, *facing(apart), free_box(3)), np.pi / 2, np.pi / 2)
    assert all(met)
    assert [set(met[i]) <= set(kept[i]) for i in (0, 1)] == [True, True]


@pytest.mark.parametrize(("apart", "first"), [(0.13, 0), (0.24, 9), (0.3, 13)])
def test_fingers_far_apart_have_skins_from_where_they_may_meet(tmp_path, apart, first):
    """Each is 0.12 m long, 20 mm wide and 19 to 20 mm thick."""
    assert skins(scenario_of(tmp_path, *facing(apart))) == [ALL[first:]] * 2


def test_a_peg_is_met_by_the_links_that_reach_it(tmp_path):
    """Its surface is 75 mm from the base in a box that is 60 mm wide; link 6 ends at 65 mm."""
    peg = f"name: peg, file: '{PEG}', X_PC: {{translation: [0.085, 0, 0]}}"
    (kept,) = skins(scenario_of(tmp_path, f"name: finger, file: '{FINGER}'", peg))
    assert 3 <= kept[0] <= 7
    assert kept == ALL[kept[0] :]


def test_a_finger_that_shears_may_reach_anything(tmp_path):
    sheared = [f"{model}, fingers: {{all: {{shear_factor: 0.857}}}}" for model in facing(0.3)]
    assert skins(scenario_of(tmp_path, *sheared)) == [ALL, ALL]


def test_a_finger_that_turns_out_of_its_plane_reaches_no_further(tmp_path):
    spatial = [f"{model}, fingers: {{all: {{yields: bending sideways twist}}}}" for model in facing(0.24)]
    assert skins(scenario_of(tmp_path, *spatial)) == [ALL[9:]] * 2
