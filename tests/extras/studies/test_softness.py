"""The compliance of a grasp: from shapes and torques that are put in, and in one grasp of two materials."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.extras.studies.softness import (
    MATERIALS,
    SECTIONS,
    Compliance,
    compliance,
    draw,
    gaps_and_forces,
    grasp_compliance,
    likeliest,
    softness_rows,
)
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.load.opening import Gripper
from soft_gripper.models import DIRECTORY

FINGER = expand_urdf(DIRECTORY / "grippers" / "finger.urdf").fingers[0]
APART = 0.1  # m, of the bases
GRIPPER = Gripper((RigidTransform(), RigidTransform(RotationMatrix.MakeZRotation(np.pi), [APART, 0, 0])))


def test_straight_fingers_have_the_gap_of_their_bases_less_their_thickness():
    q = np.zeros((1, 2, FINGER.segments))
    gaps, forces = gaps_and_forces(GRIPPER, (FINGER, FINGER), q, q)
    thickest = FINGER.section(np.linspace(0, FINGER.length, 50)).inner_face.max()
    assert gaps == pytest.approx([APART - 2 * thickest], rel=1e-3)
    assert np.isnan(forces).all()  # they are nearest at their bases


def test_a_force_at_the_tips_is_found_from_its_torques():
    """Fingers bent toward each other touch at their tips; a force across the base opens them."""
    q = np.full((1, 2, FINGER.segments), 0.03)
    levers = forward_kinematics(q, FINGER.segment_length)
    _, forces = gaps_and_forces(GRIPPER, (FINGER, FINGER), q, -0.7 * (FINGER.length - levers.joints.real))
    assert forces == pytest.approx([0.7], rel=0.1)


def test_compliance_is_the_decrease_of_the_gap_over_the_increase_of_the_force():
    assert compliance(np.array([0.044, 0.043, 0.041]), np.array([0.5, 1.0, 2.0])) == pytest.approx(2e-3)


def test_the_likeliest_material_takes_its_spread_into_account():
    trained = {"narrow": np.array([0.9, 1.0, 1.1]), "wide": np.array([1.0, 2.0, 3.0])}
    assert likeliest(np.array([1.05, 1.4, 0.0]), trained) == ["narrow", "wide", "wide"]


def test_rows_count_the_draws_of_the_sensors():
    def found(value):
        return {sections: Compliance(np.array([value, value + 0.1]) * 1e-3, value * 1e-3) for sections in SECTIONS}

    places = dict(zip(MATERIALS, (4, 2, 1, 0), strict=True))
    grasps = {(set, 0, name): found(place) for set in ("train", "test") for name, place in places.items()}
    grasps["test", 1, "wood"] = found(1.0)  # like 200 kPa
    rows = {row.material: row for row in softness_rows(grasps) if row.sections == 4}
    assert [rows[name].right_percent for name in MATERIALS] == [100, 100, 100, 50]
    assert rows["wood"].taken_for == "200 kPa 50, wood 50"
    assert rows["wood"].grasps == 2


def test_draws_differ_and_are_repeated():
    assert draw(1, "test", 0, "wood") == draw(1, "test", 0, "wood")
    assert draw(1, "test", 0, "wood") != draw(1, "train", 0, "wood")


@pytest.mark.slow
def test_a_sponge_is_more_compliant_than_wood_with_any_sensors():
    sponge, wood = (grasp_compliance(1, "test", 0, material) for material in ("20 kPa", "wood"))
    for sections in SECTIONS:
        assert sponge[sections].ideal > 2 * wood[sections].ideal
        assert sponge[sections].realistic.min() > wood[sections].realistic.max()
