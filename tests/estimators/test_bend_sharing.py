"""BendSharing: the joints of a section bend as stiffness, drive, weight and load have it; known loads are found."""

from dataclasses import replace

import numpy as np
import pytest
from finger_motion import at_rest
from finger_plants import LENGTH, uniform_finger

from soft_gripper.estimators.arc_shapes import BendSharing
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.load.force_estimator import TorqueBalance
from soft_gripper.sensors.sensor_layout import SensorLayout

PRESSURE = np.array(60e3)  # Pa
GRAVITY = -9.0 + 4.0j  # m/s^2, z + i x in B
SECTIONS = [1, 2, 3, 4, 6, 12]
LAW = ElasticLaw(curvature=(-30.0, 0.0, 30.0), base_moment=(-0.5, 0.0, 0.2), tip_moment=(-0.2, 0.0, 0.3))
STIFFENING = ElasticLaw((-30.0, -10.0, 10.0, 30.0), (-0.5, -0.12, 0.12, 0.5), (-0.44, -0.1, 0.1, 0.44))
# Softens, then stiffens: whole steps of Newton's method cycle between its pieces.
UNEVEN = ElasticLaw((-50.0, -10.0, 5.0, 12.0, 40.0), (-0.6, -0.1, 0.08, 0.1, 0.5), (-0.3, -0.1, 0.04, 0.09, 0.2))
LAWS = pytest.mark.parametrize(
    "law", [None, LAW, STIFFENING, UNEVEN], ids=["linear", "softening", "stiffening", "uneven"]
)


@pytest.fixture
def steep_finger(shipped_finger):
    """Thickness and chamber taper from 35 mm to 10 mm: the joint at the tip is 29 times as soft as the first."""
    sections = (
        replace(shipped_finger.base, thickness=t, chamber_thickness=t / 2, chamber_center=-t / 20)
        for t in (0.035, 0.01)
    )
    return replace(shipped_finger, **dict(zip(("base", "tip"), sections, strict=True)), sensor_spacing=0.009)


def sums(layout, q):
    """Bend of the sections, as exact sensors measure it."""
    return np.add.reduceat(q, layout.section_ends[:-1], axis=-1)


def found(layout, theta, pressure=PRESSURE):
    """External torque at the joints of a finger at rest, without weight, from the bend of its sections."""
    driving = layout.finger.pressure_torque(pressure)
    q = BendSharing(layout).joint_angles(theta, driving, 0.0)
    return TorqueBalance(layout.finger).external_torque(at_rest(layout.finger, q, driving), np.zeros(3), 0.01).torque


def under_load(finger, torque):
    """Joint angles of a finger at PRESSURE in balance with external torques, rad, without weight."""
    return finger.angle(torque + PRESSURE * finger.pressure_gain)


def from_force(finger, where, force):
    """Torque of a force, N, that presses across the straight finger at `where`, m, on its joints."""
    return force * np.maximum(where - finger.joint_arc_lengths, 0)


@LAWS
@pytest.mark.parametrize("sections", SECTIONS)
def test_joints_of_a_section_add_up_to_its_reading(steep_finger, bent, sections, law):
    """Whatever is read, in whatever direction gravity pulls."""
    layout = SensorLayout(replace(steep_finger, elastic_law=law), sections)
    theta, gravity = bent(50, sections), 9.81 * np.exp(1j * np.arange(50))[:, None]
    q = BendSharing(layout).joint_angles(theta, 0.05 * bent(50, 12), gravity)
    np.testing.assert_allclose(sums(layout, q), theta, rtol=0, atol=1e-14)


@LAWS
@pytest.mark.parametrize("name", ["shipped_finger", "tapered_finger", "steep_finger"])
def test_free_bending_is_exact(request, name, law):
    """With any number of sensors, of any taper."""
    finger = replace(request.getfixturevalue(name), elastic_law=law)
    pressure = np.array([-60e3, 20e3, 120e3])
    q = free_bending_angles(finger, pressure)
    for sections in range(1, min(finger.segments, 6) + 1):
        layout = SensorLayout(finger, sections)
        shared = BendSharing(layout).joint_angles(sums(layout, q), finger.pressure_torque(pressure), 0.0)
        np.testing.assert_allclose(shared, q, rtol=0, atol=1e-14)


@pytest.mark.parametrize("sections", SECTIONS)
def test_shape_under_a_load_at_the_tip_is_found_exactly(sections):
    """Equal shares are wrong by more than 1 mm at the tip with one section or two."""
    finger = uniform_finger(12)
    layout, q = SensorLayout(finger, sections), under_load(finger, from_force(finger, LENGTH, -0.8))
    sharing, theta = BendSharing(layout), sums(layout, q)
    np.testing.assert_allclose(sharing.joint_angles(theta, finger.pressure_torque(PRESSURE), 0.0), q, atol=1e-14)
    if sections <= 2:
        tips = [forward_kinematics(shape, 0.01).tip for shape in (q, sharing.layout.shared_equally(theta))]
        assert abs(tips[0] - tips[1]) > 1e-3


@LAWS
@pytest.mark.parametrize("sections", [1, 2, 4])
def test_weight_is_no_load(steep_finger, sections, law):
    """Of a finger in balance with it; an elastic law takes the weight of the shape that arcs have."""
    finger = replace(steep_finger, elastic_law=law)
    q = np.zeros(12)
    for _ in range(100):
        q = finger.angle(PRESSURE * finger.pressure_gain + gravity_torque(finger, q, GRAVITY))
    layout = SensorLayout(finger, sections)
    sharing, theta = BendSharing(layout), sums(layout, q)
    driving = finger.pressure_torque(PRESSURE)
    shapes = [sharing.joint_angles(theta, driving, gravity) for gravity in (GRAVITY, 0.0)]
    wrong, without = (np.abs(finger.elastic_torque(shape) - finger.elastic_torque(q)).max() for shape in shapes)
    assert wrong < (0.01 if law is None else 0.1) * without


@pytest.mark.parametrize("where", [0.05, 0.075, 0.1])
def test_force_between_base_and_tip_is_found_better_by_more_sensors(where):
    finger = uniform_finger(12)
    torque = from_force(finger, where, -0.5)
    q = under_load(finger, torque)
    layouts = [SensorLayout(finger, sections) for sections in (1, 2, 4, 12)]
    errors = [round(np.abs(found(layout, sums(layout, q)) - torque).max(), 12) for layout in layouts]
    assert sorted(errors, reverse=True) == errors
    assert errors[-1] == 0


@LAWS
@pytest.mark.parametrize("bad", range(3))
def test_an_unknown_section_makes_all_joints_unknown_in_its_sample_alone(shipped_finger, bent, bad, law):
    sharing = BendSharing(SensorLayout(replace(shipped_finger, elastic_law=law), 3))
    theta, driving = bent(4, 3), 0.05 * bent(4, 12)
    known = sharing.joint_angles(theta, driving, GRAVITY)
    theta[1, bad], driving[3] = np.nan, np.nan
    q = sharing.joint_angles(theta, driving, GRAVITY)
    assert np.isnan(q[[1, 3]]).all()
    np.testing.assert_array_equal(q[[0, 2]], known[[0, 2]])
