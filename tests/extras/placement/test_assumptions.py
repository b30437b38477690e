"""What an estimator is made to believe fits what goes wrong."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.extras.placement.samples import USUAL_STRAIN, Assumptions, reading_std
from soft_gripper.sensors.strain_errors import StrainErrors, disturb


def test_nothing_wrong_is_an_exact_model():
    assert Assumptions().uncertainty == Uncertainty(bend_per_pressure=EXACT)
    assert Assumptions(errors=StrainErrors()).uncertainty == Uncertainty(bend_per_pressure=EXACT)


@pytest.mark.parametrize("error", ["noise", "offset", "gain_error", "low_frequency_noise"])
def test_the_believed_error_is_that_of_many_sensors_at_the_usual_strain(error):
    errors = StrainErrors(**{error: 0.02})
    ratios = np.full((1, 20000), 1 + USUAL_STRAIN)
    wrong = disturb(errors, ratios, 0.01, np.random.default_rng(1)) - ratios
    assert wrong.std() == pytest.approx(reading_std(errors), rel=0.03)
    assert Assumptions(errors=errors).uncertainty.reading == reading_std(errors)


def test_the_believed_errors_add_up_as_squares():
    """Absolute ones as they are, and those that are a share of the strain at the usual one."""
    absolute = {"noise": 0.01, "offset": 0.02, "drift": 0.03, "low_frequency_noise": 0.04}
    relative = {"gain_error": 0.1, "hysteresis": 0.05, "creep": 0.2}
    squares = sum(value**2 for value in absolute.values()) + sum((0.05 * value) ** 2 for value in relative.values())
    assert USUAL_STRAIN == 0.05
    assert reading_std(StrainErrors(**absolute, **relative)) == pytest.approx(np.sqrt(squares))
    assert reading_std(StrainErrors(**relative)) == pytest.approx(0.05 * np.hypot(np.hypot(0.1, 0.05), 0.2))


def test_the_finger_is_believed_too_stiff_and_too_soft(shipped_finger):
    stiff, soft = Assumptions(nominal_error=10.0).nominal(shipped_finger)
    assert stiff.base.youngs_modulus == pytest.approx(1.1 * shipped_finger.base.youngs_modulus)
    assert soft.tip.youngs_modulus == pytest.approx(0.9 * shipped_finger.tip.youngs_modulus)
    assert Assumptions(nominal_error=10.0).uncertainty.bend_per_pressure == pytest.approx(0.1)
    assert Assumptions().nominal(shipped_finger) == [shipped_finger]


@pytest.mark.parametrize("nominal_error", [-1.0, 100.0, float("nan")])
def test_an_impossible_nominal_model_is_refused(nominal_error):
    with refused("--nominal-error"):
        Assumptions(nominal_error=nominal_error)


def test_an_unknown_estimator_is_refused():
    with refused("--estimator", "splines"):
        Assumptions("splines")
