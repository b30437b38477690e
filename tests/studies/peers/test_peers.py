"""The benchmark against other simulators: each of them runs for a moment, and moves the fingers as ours does."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import yaml

from studies.peers.comparison import Result, chosen_results, creep, holds, tip_error
from studies.peers.simulators import OURS, find_simulator
from studies.peers.task import PeerTrial, load_task

ROOT = Path(__file__).parents[3]
ENGINE = "soft-gripper, engine mujoco"
MODULES = {ENGINE: "mujoco", "MuJoCo": "mujoco", "PyBullet": "pybullet", "PyElastica": "elastica"}
MOMENT = ("pressure.settle=0.2", "pressure.hold_samples=10")
FREE = {"scenario": "free_bending", "overrides": ["pressure.steps.all=[60e3]", *MOMENT]}


def settings():
    with (ROOT / "studies" / "peers" / "settings.yaml").open(encoding="utf-8") as file:
        return yaml.safe_load(file)


def needs(simulator):
    if simulator in MODULES and find_spec(MODULES[simulator]) is None:
        pytest.skip(f"{simulator} is not installed; extra `peers`")


def run(simulator, spec, setting):
    needs(simulator)
    return find_simulator(simulator)(load_task(spec), setting)()


@pytest.fixture(scope="module")
def ours():
    return run(OURS, FREE, {"time_step": 0.002})


@pytest.mark.parametrize(
    ("simulator", "setting", "within"),
    [
        ("MuJoCo", {"step": 0.002, "integrator": "euler"}, 0.5e-3),
        ("PyBullet", {"step": 0.001, "implicit": True}, 1.0e-3),
        ("PyElastica", {"step": 0.00025}, 6e-3),  # its mass lies on the axis
    ],
)
def test_a_free_finger_moves_as_ours_does(ours, simulator, setting, within):
    trial = run(simulator, FREE, setting)
    assert trial.seconds > 0
    assert np.abs(ours.tips[-1] - ours.tips[0]).min() > 0.03
    assert np.abs(trial.tips - ours.tips).max() < within


def test_the_second_engine_ends_where_ours_does(ours):
    late = run(ENGINE, FREE | {"sensed": True}, {"runs": 2})
    assert np.abs(late.tips[1:] - ours.tips[:-1]).max() < 5e-3  # its long steps damp motion


def test_sensing_is_that_of_our_blocks():
    """Of all samples at once, with NaN until there are five."""
    from studies.peers.ours import make_run
    from studies.peers.sensing import sense

    task, q = load_task(FREE | {"sensed": True}), np.full((5, 2, 12), 0.05)
    assert make_run(task, {"time_step": 0.01})().seconds > 0
    strain, theta, _, angles, external = sense(task, q, np.zeros((5, 2)))
    assert strain.shape == (5, 2, 8)
    assert theta == pytest.approx(0.15, rel=1e-3)
    assert angles.sum(axis=-1) == pytest.approx(0.6, rel=1e-3)
    assert np.isnan(external[:4]).all()
    assert external[4, :, 0] == pytest.approx(task.fingers[0].stiffness[0] * 0.05, rel=0.4)  # and the weight


def test_creep_and_error_are_those_of_the_end():
    config = settings()
    task = load_task(config["tasks"]["box grasp"])
    t = np.arange(1, 801) * 0.01
    start = task.grasped_body.X_WB.translation()
    held = start + np.outer(t, [0, 0, -1e-4])
    trial = PeerTrial(1.0, np.zeros((800, 2), dtype=complex), held)
    assert creep(task, trial) == pytest.approx(1e-4)
    assert holds(task, trial)
    assert not holds(task, trial._replace(held=held + np.array([0, 0, -0.05])))
    off = trial._replace(tips=trial.tips + 1e-3 * (t > 7)[:, None])
    assert tip_error(task, off, trial) == pytest.approx(1e-3)


def result(simulator, seconds, error, stays=True):
    return Result("task", simulator, {}, np.array([seconds]), error, float("nan"), stays)


def test_the_fastest_setting_that_is_as_good_is_chosen():
    ours = result(OURS, 1.0, 1.0)
    fast, good, slow = result("A", 0.1, 2.0), result("A", 0.5, 1.05), result("A", 0.6, 0.1)
    bad, lost = result("B", 0.1, 3.0), result("B", 0.1, 0.1, stays=False)
    assert chosen_results([ours, fast, good, slow, bad, lost]) == [ours, good, bad]
    assert good.times_behind(ours) == 0.5
