"""What is said of fits whose residuals and Jacobians are known."""

import numpy as np
import pytest
from identified import recorded, release

from soft_gripper.extras.hardware.identification.fit import fit_confidence
from soft_gripper.extras.hardware.identification.free_parameters import FingerFit, free_parameters

NAMES = ["youngs_modulus", "density", "mounting_x"]
SCALES = np.array([0.1, 0.1, 1e-3])


@pytest.fixture(scope="module")
def motion(beam):
    return recorded(beam, release(6.0))


@pytest.fixture
def made_up(beam, motion):
    """A fit with a Jacobian by usual changes, (R, P), and residuals, (R,)."""

    def make(by_changes, residuals):
        free = free_parameters(beam, NAMES[: by_changes.shape[1]], [])
        slopes, weights = by_changes / free.scales, np.ones(len(residuals))
        return FingerFit(free.build_model, free.start, residuals, slopes, weights, 0.0, 0.0, True, free, (motion,))

    return make


@pytest.fixture
def rows(motion):
    return 2 * motion.markers.size


def test_deviation_of_independent_residuals(made_up, rows):
    """s / |column|, as for any linear regression; what the noise of noise makes of it is small."""
    random = np.random.default_rng(0)
    jacobian = np.linalg.qr(random.normal(size=(rows, 3)))[0] * [2.0, 3.0, 4.0]
    found = fit_confidence(made_up(jacobian, random.normal(0, 0.01, rows)))
    np.testing.assert_allclose(found.std, 0.01 / np.array([2, 3, 4]) * SCALES, rtol=0.15)
    np.testing.assert_allclose(found.correlation, np.eye(3), atol=1e-9)
    assert found.undetermined == ()


def test_residuals_that_last_count_once(made_up, rows, motion):
    """Of a first-order process with a time of L samples, 1 + 2 sum of autocorrelations is 2 L."""
    random = np.random.default_rng(1)
    samples, lasting = len(motion.time), 5.0
    kept = np.exp(-1 / lasting)
    series = random.normal(size=(samples, rows // samples))
    for k in range(1, samples):
        series[k] = kept * series[k - 1] + np.sqrt(1 - kept**2) * series[k]
    jacobian = np.linalg.qr(random.normal(size=(rows, 1)))[0]
    alone = fit_confidence(made_up(jacobian, random.permutation(series.ravel()))).std
    assert fit_confidence(made_up(jacobian, series.ravel())).std / alone == pytest.approx(
        np.sqrt(2 * lasting), rel=0.25
    )


def test_of_two_that_change_the_same_the_last_is_dropped(made_up, rows):
    """It keeps its value, and what is said of the others is what a fit without it would say."""
    random = np.random.default_rng(2)
    column, other = random.normal(size=(2, rows))
    residuals = random.normal(size=rows)
    fit = made_up(np.column_stack([column, -column, other]), residuals)
    found = fit_confidence(fit)
    (dropped,) = found.undetermined
    assert (dropped.name, dropped.beside) == ("density", ("youngs_modulus",))
    assert dropped.correlation == pytest.approx(1.0, abs=1e-3)
    assert dropped.value == pytest.approx(fit.model.finger.base.density)
    assert str(dropped).endswith("kept at 1070 kg/m^3")
    assert found.names == ["youngs_modulus", "mounting_x"]
    jacobian = np.column_stack([column, other])
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    expected = np.sqrt(np.diag(covariance) * (residuals @ residuals) / rows) * SCALES[[0, 2]]
    np.testing.assert_allclose(found.std, expected, rtol=0.2)  # the correlation time of noise is not quite 1
    assert np.isnan(found.std_of("density"))
