"""Errors of a placement: by their definition, and where models are right or wrong by a known amount."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.extras.placement.place_sensors import contact_errors, mean_pose_error
from soft_gripper.extras.placement.samples import SETS, Assumptions, read_contacts, read_held
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors


@pytest.mark.parametrize("estimator", ["arcs", "gaussian"])
@pytest.mark.parametrize("placement", [(), (4,), (3, 6, 9)])
def test_the_error_is_that_of_the_estimator_on_this_layout(free_finger, estimator, placement):
    """With ideal sensors, calculated without spans."""
    assumptions = Assumptions(estimator)
    error = mean_pose_error([read_held(free_finger, assumptions, 0)], placement, assumptions)
    finger, q = free_finger.layout.finger, free_finger.q[free_finger.held]
    borders = tuple(end / 12 for end in placement)
    layout = SensorLayout(finger, len(placement) + 1, borders=borders)
    function = SHAPE_FUNCTIONS[estimator](layout, assumptions.uncertainty)
    readings = layout.response.reading(extension_ratios(layout, q))
    joints = function(
        readings, finger.pressure_torque(free_finger.pressure[free_finger.held]), free_finger.gravity
    ).points(finger)[:, :-1]
    true = forward_kinematics(q, finger.segment_length).joints
    assert error == pytest.approx(float(np.abs(joints - true).mean()), rel=1e-9)


def test_free_bending_is_known_from_pressure_alone_if_the_stiffness_is(free_finger):
    """The model is that of the truth; assumed too stiff or too soft, the shape is wrong."""
    right, wrong = Assumptions(), Assumptions(nominal_error=20.0)
    known = mean_pose_error([read_held(free_finger, right, 0)], (6,), right)
    nominal = mean_pose_error([read_held(free_finger, wrong, 0)], (6,), wrong)
    assert known < 1e-6 < 1e-5 < nominal


def test_every_nominal_model_counts_alike(shipped_finger):
    """A straight finger that is estimated to turn by an angle at its first joint alone errs by chords about that."""
    angles, finger = (0.1, 0.4), shipped_finger
    turned = [ShapeEstimate(np.eye(finger.segments)[:1, None] * angle) for angle in angles]
    q = np.zeros((1, finger.segments))
    samples = SimpleNamespace(layout=SensorLayout(finger, 2), q=q, estimates=lambda *_: iter(turned))
    mean_arm = finger.segment_length * (finger.segments - 1) / 2
    expected = np.mean([2 * np.sin(angle / 2) * mean_arm for angle in angles])
    assert mean_pose_error([samples], (6,), Assumptions(nominal_error=10.0)) == pytest.approx(expected)


def test_noise_costs_and_every_finger_counts_alike(free_finger):
    noisy = Assumptions(errors=StrainErrors(noise=0.005))
    worse = read_held(free_finger, noisy, 0)
    other = replace(worse, q=worse.q + 0.01)
    one, two = (mean_pose_error([samples], (6,), noisy) for samples in (worse, other))
    assert one > 1e-5
    assert mean_pose_error([worse, other], (6,), noisy) == pytest.approx((one + two) / 2)


def test_each_finger_has_random_numbers_of_its_own_and_the_same_in_every_run(free_finger):
    noisy = Assumptions(errors=StrainErrors(noise=0.005))
    first, again, other = (read_held(free_finger, noisy, number).ratios.ratios for number in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert first.shape == (8, SETS, 2, 78)
    assert not np.any(first == other)


def test_only_held_samples_count_but_all_pass_through_the_sensors(free_finger):
    """Creep: of the last step, eight samples before, exp(-8 T / time constant) of the late share is still missing."""
    creeping = Assumptions(errors=StrainErrors(creep=0.5, creep_time=0.05))
    read = read_held(free_finger, creeping, 0)
    ideal = read_held(free_finger, Assumptions(), 0)
    assert len(read.q) == 8
    late = np.abs(read.ratios.ratios[:, 0] - ideal.ratios.ratios[:, 0])
    step = np.abs(ideal.ratios.ratios[6, 0] - ideal.ratios.ratios[4, 0])
    np.testing.assert_allclose(late[6], 0.5 * step * np.exp(-8 * 0.2), rtol=0.2)
    np.testing.assert_allclose(late[7], late[6] * np.exp(-0.2), rtol=1e-9)


def test_a_finger_that_creeps_remembers_how_it_was_bent(free_finger):
    """Of one that was held bent for ever."""
    finger = replace(free_finger.layout.finger, creep=(CreepBranch(0.2, 0.01),))
    bent = np.full_like(free_finger.q, 0.1)
    held = replace(free_finger, layout=replace(free_finger.layout, finger=finger), q=bent)
    (driving,) = read_held(held, Assumptions(), 0).driving
    known = finger.pressure_torque(held.pressure[held.held])[2:]
    np.testing.assert_allclose(driving[2:] - known, np.tile(0.02 * finger.stiffness, (6, 1)), rtol=1e-6)


@pytest.fixture
def contacts(free_finger):
    """Four that are no contacts, though they are said to be."""
    held, gravity = free_finger.held[::2], in_space(free_finger.gravity[::2])
    return Contacts(
        free_finger.layout.finger,
        *(free_finger.q[held], free_finger.pressure[held], gravity),
        normal_force=np.array([1.0, 1.0, 2.0, 3.0]),
        force=np.zeros((4, 3)),
        torque=np.zeros((4, 12)),
        arc_length=np.array([0.05, 0.06, 0.07, 0.08]),
        side=np.array([0, np.pi, 0, 0]),
        friction=np.zeros(4),
    )


def test_errors_of_force_and_place(contacts, monkeypatch):
    """An estimator that finds 1 N at 60 mm, and nothing in the last."""

    def estimate(layout, uncertainty, period):
        def function(readings, driving, gravity):
            shape = readings.shape[:-1]
            place = np.broadcast_to([[0.06], [0.06], [0.06], [np.nan]], shape)
            force = np.broadcast_to([[1.0], [1.0], [1.0], [0.0]], shape)
            return ShapeEstimate(np.zeros((*shape, 12)), contact=ContactForce(force, place, force, place))

        return function

    monkeypatch.setitem(SHAPE_FUNCTIONS, "contact", estimate)
    assumptions = Assumptions("contact", StrainErrors(noise=1e-3))
    samples = read_contacts(contacts, SensorLayout(contacts.finger, 4), assumptions, 0)
    found = contact_errors(contacts, samples, (4,), assumptions)
    assert found.force == pytest.approx((0 + 2 + 1 + 3) / 4)
    assert found.place == pytest.approx((0.01 + 0 + 0.01) / 3)
    assert found.missed == pytest.approx(0.25)


@pytest.mark.parametrize("placement", [(4,), ()])
def test_where_all_are_missed_there_is_no_place(contacts, placement):
    """The finger hangs free, and `contact` says so; with a single section it knows nothing."""
    assumptions = Assumptions("contact")
    samples = read_contacts(contacts, SensorLayout(contacts.finger, 4), assumptions, 0)
    found = contact_errors(contacts, samples, placement, assumptions)
    assert found.missed == 1
    assert np.isnan(found.place)
    assert found.force == pytest.approx(7 / 4)
