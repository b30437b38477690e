"""Fingers drawn as they are estimated: where their links are, in the plane and in space, and on a base that moves."""

from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.estimate_scene import EstimateScene
from soft_gripper.scenario.scenario_file import load_scenario


def scene(name, moving=(), *changes):
    scenario, meshcat = load_scenario(name, changes), hidden_meshcat()
    bench = Bench(scenario, moving)
    return EstimateScene(scenario, bench.signals, moving, meshcat), scenario, meshcat, bench


def estimates(drawn, bench):
    """Of fingers that read nothing but zeros."""
    bench.step({name: np.zeros(size) for name, size in bench.inputs.items()})
    return dict(bench.read(drawn.signals))


@pytest.mark.parametrize("name", ["tip_distance_steps", "three_chambers", "tendon_grasp"])
def test_every_signal_that_is_drawn_is_estimated(name):
    changes = ["estimator.type=gaussian"]
    drawn, _, meshcat, bench = scene(name, (), *changes)
    assert set(drawn.signals) <= bench.signals.keys()
    drawn.show(estimates(drawn, bench))
    assert meshcat.HasPath("/drake/visualizer")
    assert meshcat.HasPath("/drake/estimate/band")


def test_joints_follow_their_estimates_and_stay_while_these_are_unknown():
    drawn, _, _, bench = scene("tip_distance_steps", (), "estimator.type=gaussian")
    values = estimates(drawn, bench)
    angles = np.linspace(0.01, 0.05, 12)
    drawn.show(values | {"left_finger.estimated_joint_angles": angles})
    places = drawn._positions["left_finger.estimated_joint_angles"]
    np.testing.assert_array_equal(drawn._posed.positions[places], angles)
    drawn.show(values | {"left_finger.estimated_joint_angles": np.full(12, np.nan)})
    np.testing.assert_array_equal(drawn._posed.positions[places], angles)


def test_a_base_that_moves_carries_the_gripper_and_no_arm():
    fingers = ["left_finger", "right_finger"]
    name, changes = "pick_and_place_box", ["task=null", "control.set_points=[0.06]"]
    drawn, _, meshcat, _ = scene(name, fingers, *changes)
    assert not meshcat.HasPath("/drake/visualizer/arm")
    X_WB, found = RigidTransform(RollPitchYaw(np.pi, 0.0, 0.3), [0.4, 0.1, 0.2]), {}
    drawn._meshcat = SimpleNamespace(SetTransform=found.__setitem__)
    drawn.show({"left_finger.X_WB": X_WB.GetAsMatrix34().ravel()})
    carried = found["/drake"] @ drawn._base.X_WB
    np.testing.assert_allclose(carried.GetAsMatrix34(), X_WB.GetAsMatrix34(), atol=1e-12)
