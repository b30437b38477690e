"""The pairs of an exported file: shapes that may touch, and the friction between them."""

import re

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.export.mjcf import station_mjcf
from soft_gripper.extras.export.reach import reaches
from soft_gripper.extras.export.tree import child_joints
from soft_gripper.scenario.scenario_file import changed_scenario


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
