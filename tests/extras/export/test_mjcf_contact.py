"""Contacts in exported files: their stiffness, friction and masks, and pairs that may touch."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.extras.export.mjcf import station_mjcf, to_mjcf
from soft_gripper.extras.export.mjcf_contact import (
    DampedContact,
    ShapeSurface,
    Skin,
    StatedContact,
    contact_settings,
    mixed,
    stated_contact,
    touch,
)
from soft_gripper.extras.export.reach import reaches
from soft_gripper.extras.export.tree import child_joints
from soft_gripper.scenario.scenario_file import changed_scenario, load_scenario
from soft_gripper.truth.contact import combined_friction

SKIN = ShapeSurface(0.9, 1e-3, 80.0)
TIP, ROOT, FIXED = (
    SKIN._replace(mobility=200.0, compliance=2e-3),
    SKIN._replace(mobility=40.0),
    SKIN._replace(mobility=0),
)
USUAL = Skin(SKIN.friction, SKIN.mobility)
BOX, TABLE, PALM = ShapeSurface(0.8, 0.0, 20.0), ShapeSurface(0.5, 0.0, 0.0), ShapeSurface(1.0, 0.0, 0.0)


def stiffness(of):
    return 1 / of.time**2


@pytest.mark.parametrize("pair", list(itertools.combinations_with_replacement([SKIN, TIP, ROOT], 2)))
def test_two_skins_are_mixed_to_the_stiffness_of_both(pair):
    found = mixed(*(stated_contact(surface, USUAL) for surface in pair))
    assert stiffness(found) == pytest.approx(stiffness(touch(*pair)), rel=5e-3)
    assert found.friction == 0.9


def test_a_contact_has_the_stiffness_of_its_skin():
    """K = k / ((1 - d) mobility), with the compliances of both and the mobilities of both."""
    found = touch(SKIN, BOX)
    assert stiffness(found) / (0.05 * (80 + 20)) == pytest.approx(1e3)
    assert found.friction == combined_friction(0.9, 0.8)


def test_mixing_is_that_of_mujoco():
    mujoco = pytest.importorskip("mujoco")
    one, other = StatedContact(DampedContact(0.7, 0.01), 3.0), StatedContact(DampedContact(0.5, 0.02), 1.0)
    geoms = "".join(
        f'<body pos="0 0 {z}"><freejoint/><geom size="0.1" friction="{s.touch.friction}" solmix="{s.weight}" '
        f'solref="{s.touch.time} 1"/></body>'
        for z, s in ((0, one), (0.19, other))
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert (data.contact[0].friction[0], data.contact[0].solref[0]) == pytest.approx(mixed(one, other))


def test_only_pairs_that_would_be_mixed_wrong_are_listed():
    surfaces = [SKIN, TIP, BOX, TABLE, PALM]
    found = contact_settings(surfaces, list(itertools.combinations(range(5), 2)), set(), 4, 0.01)
    # Skins, and a skin on the palm, whose friction is the larger one, are mixed; so is no pair of rigid shapes here.
    assert set(found.pairs) == {(0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (2, 4), (3, 4)}
    assert found.pairs[0, 2]["condim"] == "4"
    assert found.pairs[2, 3]["condim"] == "3"
    assert float(found.geoms[4]["friction"].split()[0]) == combined_friction(0.9, 1.0)


@pytest.mark.parametrize("shapes", [3, 20, 60])
def test_masks_and_pairs_together_are_the_candidates(shapes):
    """However many groups of shapes there are: MuJoCo has 31 bits."""
    rng = np.random.default_rng(shapes)
    candidates = [pair for pair in itertools.combinations(range(shapes), 2) if rng.random() < 0.5]
    found = contact_settings([SKIN] * shapes, candidates, set(), 4, 0.01)
    bits = [(int(geom["contype"]), int(geom["conaffinity"])) for geom in found.geoms]
    by_mask = {
        (i, k)
        for i, k in itertools.combinations(range(shapes), 2)
        if bits[i][0] & bits[k][1] or bits[k][0] & bits[i][1]
    }
    assert by_mask | set(found.pairs) == set(candidates)
    assert by_mask.isdisjoint(found.pairs)


@pytest.mark.parametrize("name", ["box_grasp", "bottle_grasp"])
def test_every_candidate_of_drake_that_can_touches_in_mujoco_and_nothing_else(name):
    mujoco = pytest.importorskip("mujoco")
    scenario = load_scenario(name)
    exported = to_mjcf(scenario, 0.002)
    model = mujoco.MjModel.from_xml_string(
        exported.text, {mesh: path.read_bytes() for mesh, path in exported.meshes.items()}
    )
    wanted = drake_candidates(scenario)
    assert sum(wanted.values()) > 8 * model.npair > 0
    found = touching_in(model)
    beyond = {pair: count for pair, count in wanted.items() if pair not in found}
    assert found | beyond == wanted
    # Fingers that hang above the table, see test_reach.
    assert all("finger_link" in one and other == "table::top" for one, other in beyond)


def drake_candidates(scenario):
    """Pairs of names of bodies, with how many shapes of both may touch."""
    station = make_station(replace(scenario, contact="points"))
    inspector, plant, found = station.parts.scene_graph.model_inspector(), station.plant, {}
    for pair in inspector.GetCollisionCandidates():
        names = [plant.GetBodyFromFrameId(inspector.GetFrameId(each)).scoped_name().get_full() for each in pair]
        if all(inspector.GetProximityProperties(each) is not None for each in pair):
            found[tuple(sorted(names))] = found.get(tuple(sorted(names)), 0) + 1
    return {tuple(name.replace("WorldModelInstance::WorldBody", "world") for name in k): v for k, v in found.items()}


def touching_in(model):
    """The same of MuJoCo: by bits, unless bodies are fixed to each other or neighbors; and by pairs."""
    found, pairs = {}, set(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True))
    pairs = {tuple(sorted(pair)) for pair in pairs}
    weld, parent = model.body_weldid, model.body_weldid[model.body_parentid[model.body_weldid]]
    for pair in itertools.combinations(range(model.ngeom), 2):
        bodies = [model.geom_bodyid[geom] for geom in pair]
        (one, other), (of_one, of_other) = ([each[b] for b in bodies] for each in (weld, parent))
        is_filtered = one == other or (of_one == other != 0) or (of_other == one != 0)
        contype, conaffinity = model.geom_contype[list(pair)], model.geom_conaffinity[list(pair)]
        by_bits = contype[0] & conaffinity[1] or contype[1] & conaffinity[0]
        if pair in pairs or (by_bits and not is_filtered):
            names = tuple(sorted(model.body(b).name for b in bodies))
            found[names] = found.get(names, 0) + 1
    return found


def station(name, changes=None):
    return make_private_station(changed_scenario(name, {"contact": "points"} | (changes or {})))


@pytest.mark.parametrize("name", ["box_grasp", "pick_and_place_box"])
def test_no_joint_moves_a_body_out_of_its_ball(name):
    plant = station(name).plant
    balls, context, random = reaches(plant, child_joints(plant)), plant.CreateDefaultContext(), np.random.default_rng(0)
    begin = plant.GetPositions(context)
    least, most = (np.clip(each, -3, 3) for each in (plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()))
    off = np.full(plant.num_bodies(), -np.inf)
    for _ in range(40):
        q = random.uniform(least, most)
        for body in map(plant.get_body, plant.GetFloatingBaseBodies()):
            first = body.floating_positions_start()
            q[first : first + 7] = begin[first : first + 7]
        plant.SetPositions(context, q)
        for index, ball in balls.items():
            place = plant.get_body(index).EvalPoseInWorld(context).translation()
            off[int(index)] = max(off[int(index)], np.linalg.norm(place - ball.center) - ball.radius)
    assert off.max() < 1e-9
    assert np.isfinite(off).sum() > 26  # not all bodies are free


def test_a_hanging_gripper_touches_the_table_only_where_it_can_reach_it():
    def names(changes):
        text = station_mjcf(station("box_grasp", changes), 0.005, is_explicit=False).text
        return [line for line in text.splitlines() if "<pair" in line and "table" in line and "link" in line]

    assert not names({})
    low = names({"models.gripper.X_PC.translation.2": 0.16, "models.box.X_PC.translation.0": 0.3})
    links = {int(re.search(r"link_(\d+)", line).group(1)) for line in low}
    assert max(links) == 12
    assert 0 < min(links) < 12


def test_friction_of_every_pair_stops_within_two_steps():
    """Else what is carried on a circle slides outward, see test_mjcf_contact."""
    pairs = re.findall("<pair .*/>", station_mjcf(station("box_grasp"), 0.004, is_explicit=False).text)
    assert len(pairs) > 100
    times = [float(re.search(r'solreffriction="(\S+) 1', pair).group(1)) for pair in pairs]
    assert times == [0.008] * len(pairs)
