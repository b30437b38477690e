"""A model whose objects are changed is the one that would be exported with these objects."""

import numpy as np
import pytest

from soft_gripper.diagrams.station import make_private_station
from soft_gripper.scenario.scenario_file import changed_scenario

mujoco = pytest.importorskip("mujoco")

from soft_gripper.extras.mujoco_engine.plants import export_to_mujoco  # noqa: E402
from soft_gripper.extras.mujoco_engine.variation import begin_positions, blocks_key, station_key, variation, vary_model  # noqa: E402

BASE = {"engine": "mujoco"}
OTHER = BASE | {
    "models.box.mass": 0.3,
    "models.box.friction": 0.35,
    "models.box.X_PC.translation.0": 0.004,
}


def test_masses_frictions_and_poses_are_numbers_of_one_model():
    plain = {"models.box.mass": 0.1, "models.box.friction": 0.8}
    base, other = (changed_scenario("box_grasp", plain | changes) for changes in (BASE, OTHER))
    assert station_key(base) == station_key(other)
    stations = [make_private_station(scenario, composed=False) for scenario in (base, other)]
    of = variation(other, base)
    one, two = (export_to_mujoco(station, 0.005, ["box"]) for station in stations)
    found = vary_model(one.model, one.pairs, stations[0].plant, of, base.contact_points)
    for field in ("body_mass", "body_inertia", "body_invweight0", "dof_invweight0", "pair_friction", "pair_solref"):
        expected = getattr(two.model, field)
        np.testing.assert_allclose(getattr(found, field), expected, rtol=1e-9, atol=1e-12, err_msg=field)
        assert field.startswith("dof") or not np.allclose(getattr(one.model, field), expected, rtol=1e-6)
    context = stations[1].plant.CreateDefaultContext()
    assert begin_positions(stations[0].plant, of) == pytest.approx(stations[1].plant.GetPositions(context))


def test_what_one_station_cannot_serve_has_another_key():
    base = changed_scenario("box_grasp", BASE)
    for changes in (
        {"sensor.sections": 2},
        {"models.gripper.fingers.all.youngs_modulus": 3e5},
        {"models.box.mass": 0.3},
    ):
        assert station_key(changed_scenario("box_grasp", BASE | changes)) != station_key(base)


def test_blocks_are_shared_by_tasks_with_other_goals_and_sizes():
    base, other = (
        changed_scenario("pick_and_place_irregular", BASE | changes)
        for changes in ({}, {"models.irregular.mesh.scale": 0.0011, "task.pose_error.x": 0.002})
    )
    assert station_key(base) != station_key(other)
    assert blocks_key(base) == blocks_key(other)
