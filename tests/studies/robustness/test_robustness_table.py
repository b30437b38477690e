"""The table of robustness: a row for every case, means of what the errors are, and noise that makes them larger."""

import numpy as np
import pytest

from studies.robustness import rows as module
from studies.robustness.rows import NominalError, estimated, robustness_table

NAMES = ("arcs", "gaussian")
NOMINAL_ERRORS = (NominalError(), NominalError(-0.1, 0.01))


def test_a_row_for_every_nominal_model_number_of_sensors_and_estimator(held) -> None:
    rows = robustness_table("free", [held], 0.0, 5, NAMES, NOMINAL_ERRORS)
    expected = [(b.name, n, name) for b in NOMINAL_ERRORS for n in (1, 2, 3, 4) for name in ("arcs", "gaussian")]
    assert [(row.nominal, row.sections, row.estimator) for row in rows] == expected
    assert {(row.scenario, row.noise, row.seeds) for row in rows} == {("free", 0.0, 5)}
    assert all(row.mean_mm <= row.p95_mm <= row.worst_mm for row in rows)
    assert all(np.isnan(row.coverage) == (row.estimator == "arcs") for row in rows)


def test_worse_sensors_and_nominal_models_cost_accuracy(held) -> None:
    def error(noise: float, nominal: NominalError) -> float:
        (row,) = (
            row
            for row in robustness_table("free", [held], noise, 3, NAMES, [nominal])
            if (row.estimator, row.sections) == ("gaussian", 1)
        )
        return row.mean_mm

    exact = error(0.0, NominalError())
    assert error(4.0, NominalError()) > error(1.0, NominalError()) > 10 * exact
    assert error(0.0, NominalError(-0.1, 0.01)) > 10 * exact


def row_of(held, nominal: NominalError, estimator: str, sections: int = 1):
    """With ideal sensors."""
    rows = robustness_table("free", [held], 0.0, 1, NAMES, [nominal])
    (row,) = (row for row in rows if (row.estimator, row.sections) == (estimator, sections))
    return row


def test_a_pressure_that_is_read_wrong_misleads_an_estimator_that_uses_it_and_no_other(held) -> None:
    """By the share of the bend that `gaussian` believes in; sensors this good leave little of it with four."""
    exact, wrong = (row_of(held, NominalError(pressure=share), "gaussian") for share in (0.0, 0.2))
    assert wrong.mean_mm > 10 * exact.mean_mm
    assert row_of(held, NominalError(pressure=0.2), "arcs").mean_mm == row_of(held, NominalError(), "arcs").mean_mm


def test_errors_of_stiffness_and_pressure_add_up_as_their_signs_say(held) -> None:
    """A finger assumed too soft and a pressure read too high both promise too much bend."""
    alone = row_of(held, NominalError(-0.1), "gaussian").mean_mm
    assert row_of(held, NominalError(-0.1, 0.05), "gaussian").mean_mm > 1.2 * alone
    assert row_of(held, NominalError(-0.1, -0.05), "gaussian").mean_mm < 0.8 * alone


def test_an_estimator_expects_its_nominal_models_to_be_as_wrong_as_they_are(held, monkeypatch) -> None:
    """Of stiffness and pressure together; beside the half percent of a finger that is known."""
    expected = []
    monkeypatch.setattr(module, "estimated", lambda *given: expected.append(given[2]) or estimated(*given))
    row_of(held, NominalError(-0.06, 0.08), "gaussian")
    found = np.array([uncertainty.bend_per_pressure for uncertainty in expected])
    np.testing.assert_allclose(found, np.hypot(0.1, 0.005))


@pytest.mark.parametrize(("noise", "sets"), [(0.0, 1), (1.0, 4)])
def test_so_many_sets_of_sensors_are_read(held, monkeypatch, noise, sets) -> None:
    seeds = []
    monkeypatch.setattr(module, "estimated", lambda *given: seeds.append(given[4].shape[1]) or estimated(*given))
    robustness_table("free", [held], noise, 4, NAMES, NOMINAL_ERRORS[:1])
    assert set(seeds) == {sets}


def test_fingers_are_taken_together(held) -> None:
    one, twice = (robustness_table("free", [held] * n, 1.0, 2, NAMES, NOMINAL_ERRORS[:1]) for n in (1, 2))
    for row, same in zip(one, twice, strict=True):
        assert (row.mean_mm, row.worst_mm) == pytest.approx((same.mean_mm, same.worst_mm))
