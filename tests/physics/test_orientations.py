"""The arm tilts and turns the gripper: fingers report their load, and not how they hang, in every orientation."""

import numpy as np
import pytest
from arm_plants import POSTURES, ur5e
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.schema import ModelConfig

pytestmark = pytest.mark.slow

FINGERS = ("left_finger", "right_finger")
BASE = 0.03  # m, where the fingers of the gripper begin
PEG = 0.0245  # m from the plane between the fingers: a peg that just misses a straight finger


def at_rest(home, pressure, *models, is_compensated=True):
    """What is recorded of both fingers, the arm at home."""
    scenario = ur5e(home)
    scenario.models += models
    scenario.pressure.steps = {"all": [pressure]}
    scenario.pressure.settle, scenario.pressure.hold_samples = 1.2, 1
    scenario.estimator.compensate_gravity = is_compensated
    return run_station(make_station(scenario))


def torques(recording, kind, sample=-1):
    """Of both fingers, N m."""
    return np.array([recording[f"{finger}.{kind}"].values[sample] for finger in FINGERS])


@pytest.mark.parametrize("pressure", [0.0, 50e3])
@pytest.mark.parametrize("home", POSTURES)
def test_a_free_finger_reports_nothing(home, pressure):
    recording = at_rest(home, pressure)
    assert not torques(recording, "true_external_torque").any()
    assert np.abs(torques(recording, "external_torque")).max() < 2e-4


@pytest.mark.parametrize("home", POSTURES)
def test_a_finger_that_is_pressed_against_a_peg_reports_just_that(home):
    """Pegs stand at the middle of a sensor section, 75 mm from the base, as in the obstructed scenarios: estimated
    torques are linear between middles of sections, and kink there, as the true ones do where a finger is pressed.
    """
    pegs = [
        ModelConfig(
            name,
            "package://soft_gripper/objects/peg.sdf",
            parent="gripper::palm",
            X_PC=Transform(RigidTransform([x, 0, BASE + 0.075])),
        )
        for name, x in (("left", -PEG), ("right", PEG))
    ]
    recording = at_rest(home, 60e3, *pegs)
    truth = torques(recording, "true_external_torque")
    assert np.abs(truth[:, 0]).max() > 5e-3
    assert np.abs(torques(recording, "external_torque_error")).max() <= 2e-3
