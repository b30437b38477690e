"""Springs that a discrete plant solves implicitly: steps of any length, and the statics of linear springs."""

import numpy as np
import pytest
from finger_plants import free_bending
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station

FINGERS = ("left_finger", "right_finger")
IMPLICIT = [f"models.{finger}.springs=implicit" for finger in FINGERS]
WAYS = ("bending", "bending sideways twist", "bending sideways twist stretch")


def of_both(field, value):
    return [f"models.{finger}.fingers.all.{field}={value}" for finger in FINGERS]


@pytest.mark.parametrize("ways", WAYS)
def test_they_rest_where_linear_springs_do(ways):
    """Up to the regularisation of Drake's solver, in the plane and across it.

    Without the layer, whose stretch it would not solve as stiff as it is.
    """
    soft = [*of_both("layer_thickness", 0), *of_both("layer_modulus", 0), *of_both("chamber_center", -3e-3)]
    common = [*soft, *of_both("yields", ways), *of_both("relaxation_time", 0.02), "gravity=[1.0, 2.0, -6.0]"]
    linear, implicit = (simulate(free_bending([10e3], 4.0, *common, *more)) for more in ((), IMPLICIT))
    tips = [recording["left_finger.true_tip_position"].values[-1] for recording in (linear, implicit)]
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-4)


@pytest.mark.parametrize("ways", WAYS)
@pytest.mark.parametrize("relaxation_time", [0.0, 1e-3])
def test_a_step_is_never_too_long(ways, relaxation_time, caplog):
    """Where it is too long for linear springs, implicit ones are chosen, and that is said."""
    little = [*of_both("yields", ways), *of_both("relaxation_time", relaxation_time)]
    with refused("time_step", 0.01):
        make_station(free_bending([80e3], 1.0, *little, *(f"models.{finger}.springs=linear" for finger in FINGERS)))
    with caplog.at_level("WARNING"):
        recording = simulate(free_bending([80e3, 0.0], 1.0, *little))
    assert "springs are implicit" in caplog.text
    bend = recording["left_finger.sampled_joint_angles"].values.sum(axis=-1)
    assert np.abs(bend).max() < np.radians(120)  # the bend at rest is 60 degrees


def test_they_need_a_discrete_plant():
    with refused("springs", "implicit"):
        make_station(free_bending([80e3], 1.0, "plant_config.time_step=0", *IMPLICIT))
