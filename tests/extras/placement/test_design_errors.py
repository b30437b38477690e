"""Predicted errors are those that the estimators state, and what they make of sensors with errors is about as large."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import EXACT
from soft_gripper.extras.placement.catalogue import CURVATURE, STRAIN, Design, errors_of
from soft_gripper.extras.placement.errors import Assumptions, Errors, Judge
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout

REALISTIC = Assumptions("realistic", 10.0)
PLANAR = Design(STRAIN, (0.3333, 0.6667))


def test_nothing_wrong_is_an_exact_model(shipped_finger):
    exact = Assumptions()
    assert exact.uncertainty(STRAIN).bend_per_pressure == EXACT
    assert exact.nominal(shipped_finger) == [shipped_finger]
    assert exact.errors(CURVATURE) is None


def test_the_finger_is_believed_too_stiff_and_too_soft(shipped_finger):
    stiff, soft = REALISTIC.nominal(shipped_finger)
    assert stiff.base.youngs_modulus == pytest.approx(1.1 * shipped_finger.base.youngs_modulus)
    assert soft.tip.youngs_modulus == pytest.approx(0.9 * shipped_finger.tip.youngs_modulus)
    assert REALISTIC.uncertainty(STRAIN).bend_per_pressure == pytest.approx(0.1, rel=1e-2)
    assert REALISTIC.errors(CURVATURE) == errors_of(CURVATURE, "realistic")


@pytest.mark.parametrize("nominal_error", [-1.0, 100.0, float("nan")])
def test_an_impossible_nominal_model_is_refused(nominal_error):
    with refused("--nominal-error"):
        Assumptions(nominal_error=nominal_error)


def test_the_score_is_of_what_there_is():
    assert Errors(1e-3, np.nan, 0.1, 1e-3).score == pytest.approx((1e-3 * 0.1 * 1e-3) ** (1 / 3))
    assert Errors(2e-3, np.nan, np.nan, np.nan).score == pytest.approx(2e-3)


def test_predicted_errors_are_those_that_contact_states(in_plane):
    """The root mean square of its standard deviations, of sensors without errors."""
    predicted = Judge([in_plane], REALISTIC).predicted(PLANAR)
    contacts, finger = in_plane.contacts, in_plane.finger
    layout = sensor_layout(finger, SensorConfig(sections=3, borders=list(PLANAR.borders)))
    driving = finger.pressure_torque(contacts.pressure)
    shape = estimator_function("contact", layout, REALISTIC.uncertainty(STRAIN))(
        layout.read(contacts.q), driving, contacts.gravity
    )
    assert predicted.force == pytest.approx(np.sqrt(np.mean(shape.contact.force_std**2)))
    place = np.where(np.isfinite(shape.contact.arc_length), shape.contact.arc_length_std, finger.length / np.sqrt(12))
    assert predicted.place == pytest.approx(np.sqrt(np.mean(place**2)))
    assert np.isnan(predicted.twist)
    gaussian = estimator_function("gaussian", layout, REALISTIC.uncertainty(STRAIN))
    np.testing.assert_allclose(
        shape.covariance, gaussian(layout.read(contacts.q), driving, contacts.gravity).covariance
    )
    assert 1e-4 < predicted.pose < 3e-3


def test_more_sensors_leave_less(in_plane, in_space):
    for samples, designs in (
        (in_plane, [Design(STRAIN, ()), PLANAR]),
        (
            in_space,
            [Design(STRAIN, (0.5,), ("inner", "left")), Design(STRAIN, (0.5,), ("inner", "left", "outer_rising"))],
        ),
        (in_space, [Design(CURVATURE, (0.5,)), Design(CURVATURE, (0.25, 0.5, 0.75))]),
    ):
        few, many = (Judge([samples], REALISTIC).predicted(design) for design in designs)
        assert many.score < few.score
        assert many.pose < few.pose


@pytest.mark.parametrize("estimator", ["contact", "gaussian"])
def test_exact_sensors_of_an_exact_finger_err_little(in_plane, estimator):
    made = Judge([in_plane], Assumptions()).made(Design(STRAIN, (0.25, 0.5, 0.75)), estimator, 0)["contacts"]
    assert made.pose < 2e-4
    assert np.isnan(made.force) == (estimator == "gaussian")
    if estimator == "contact":
        assert made.force < 0.1
        assert made.place < 6e-3


@pytest.mark.parametrize(
    "design", [PLANAR, Design(STRAIN, (0.5,), ("inner", "outer", "left", "outer_rising"))], ids=str
)
def test_made_errors_are_about_the_predicted_ones(in_plane, in_space, design):
    samples = in_space if design.paths else in_plane
    judge = Judge([samples], REALISTIC)
    ratio = np.array(judge.made(design, "contact", 0)["contacts"]) / judge.predicted(design)
    known = ratio[np.isfinite(ratio)]
    assert len(known) == (4 if design.paths else 3)
    assert known.min() > 0.2
    assert known.max() < 3


def test_random_numbers_belong_to_the_design(in_plane):
    judge = Judge([in_plane], REALISTIC)
    once, again, other = (judge.made(PLANAR, "contact", number) for number in (0, 0, 1))
    assert once == again or np.isnan(once["contacts"].twist)
    assert once["contacts"].pose == again["contacts"].pose != other["contacts"].pose


def test_an_estimator_of_the_plane_is_refused_in_space(in_plane, in_space):
    Judge([in_plane], REALISTIC).check("arcs")
    with refused("type", "arcs"):
        Judge([in_space], REALISTIC).check("arcs")
