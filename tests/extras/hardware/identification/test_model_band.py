"""Bands of an identified finger's markers: where it was fitted and beyond, and the file that keeps its states."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from refusals import refused

from soft_gripper.extras.hardware.identification.free_parameters import FingerFit, Model
from soft_gripper.extras.hardware.identification.model_band import STATES, band_rows, extrapolations, learned_band
from soft_gripper.extras.hardware.identification.settled_states import IdentifiedStates, SettledStates, StateScore
from soft_gripper.extras.hardware.identification.settled_states import TestedStates as Compared
from soft_gripper.fingers.paths import Tendon

NOISE = 2e-4  # m


@pytest.fixture(scope="module")
def finger(shipped_finger):
    return replace(shipped_finger, tendons=tuple(Tendon(f"t{i}", (0.0,), (5e-3,), stiffness=1e3) for i in range(2)))


def marker(pulled, rng):
    """A marker that moves by more than in proportion, of which a linear model knows nothing."""
    bent = pulled + 20 * pulled**2
    return np.column_stack([bent, bent.sum(axis=-1)])[:, None] + rng.normal(0, NOISE, (len(pulled), 1, 3))


def states_of(name, pulled):
    at = SettledStates(name, pulled, np.zeros((len(pulled), 1, 3)), np.zeros((1, 3)), np.array([]), np.zeros(3))
    return at, StateScore(name, "test", "all", "all", len(pulled), 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def found(finger):
    """A linear fit to states in which both tendons are pulled up to 5 mm, or one of them up to 10."""
    rng = np.random.default_rng(0)
    pulled = np.concatenate([rng.uniform(0, 5e-3, (150, 2)), rng.uniform(0, 1e-2, (60, 1)) * [1.0, 0.0]])
    slopes = np.kron(np.column_stack([pulled, np.ones(len(pulled))]), np.eye(3))
    measured = marker(pulled, rng).ravel()
    x = np.linalg.lstsq(slopes, measured)[0]
    errors = (slopes @ x - measured).reshape(-1, 1, 3)
    free = SimpleNamespace(scales=np.ones(len(x)))
    fit = FingerFit(np.asarray, x, errors.ravel(), slopes, np.ones(errors.size), 0.0, 0.0, True, free, ())
    states, score = states_of("fitted", pulled)
    return IdentifiedStates(Model(finger), (states,), (errors,), (score,), (errors,), fit, None)


def compared(found, name, pulled, seed=1):
    """Other states, and what the fit predicts in them."""
    states, score = states_of(name, pulled)
    slopes = np.kron(np.column_stack([pulled, np.ones(len(pulled))]), np.eye(3))
    errors = (slopes @ found.fit.x).reshape(-1, 1, 3) - marker(pulled, np.random.default_rng(seed))
    return Compared(found.model, (states,), (errors,), (score,))


def test_markers_are_in_their_bands_where_the_finger_was_fitted_and_beyond(found):
    kept, rng = learned_band(found), np.random.default_rng(2)
    (near,) = band_rows(kept, compared(found, "near", rng.uniform(0, 5e-3, (200, 2))))
    (beyond,) = band_rows(kept, compared(found, "both", rng.uniform(6e-3, 9e-3, (200, 2))))
    assert near.within_band_percent > 90
    assert near.far_percent < 5
    assert beyond.within_band_percent > 90
    assert beyond.far_percent > 95, "each tendon was pulled as far, but not both"
    assert 1.5 * near.band_mm < beyond.band_mm < 10 * near.band_mm
    assert extrapolations([near, beyond]) == ["both: 100 % of it is far from what was fitted"]


def test_bands_are_wide_where_errors_were_large_in_the_fit(finger):
    """Noise that is ten times as large where the tendons are pulled in, and never in between."""
    rng = np.random.default_rng(3)
    pulled = np.concatenate([rng.uniform(0, 1e-3, (100, 2)), rng.uniform(9e-3, 1e-2, (100, 2))])
    errors = rng.normal(0, NOISE, (200, 1, 3)) * np.repeat([1, 10], 100)[:, None, None]
    free, weights = SimpleNamespace(scales=np.ones(1)), np.ones(600)
    fit = FingerFit(np.asarray, np.zeros(1), errors.ravel(), np.ones((600, 1)), weights, 0.0, 0.0, True, free, ())
    states, score = states_of("fitted", pulled)
    kept = learned_band(IdentifiedStates(Model(finger), (states,), (errors,), (score,), (errors,), fit, None))
    for rows, noise in ((slice(100), NOISE), (slice(100, None), 10 * NOISE)):
        part, score = states_of("part", pulled[rows])
        (row,) = band_rows(kept, Compared(Model(finger), (part,), (errors[rows],), (score,)))
        assert 85 < row.within_band_percent <= 100
        assert 2 * noise < 1e-3 * row.band_mm < 5 * noise


def test_the_states_beside_a_finger_are_those_that_were_kept(found, tmp_path):
    assert STATES.read(tmp_path / "finger.urdf") is None
    kept = learned_band(found)
    STATES.write(tmp_path / "finger.urdf", kept)
    assert STATES.read(tmp_path / "finger.urdf") == kept
    assert kept.names == ["t0 [m]", "t1 [m]", "load [kg]"]
    assert len(kept.states) == 210


def test_states_of_another_finger_are_refused(found):
    kept = learned_band(found)
    with refused("states", 2):
        other = replace(kept, names=kept.names[:2], spread=kept.spread[:2], states=[s[:2] for s in kept.states])
        band_rows(other, compared(found, "near", np.zeros((3, 2))))


def test_impossible_states_are_refused(found, tmp_path):
    file = STATES.file(tmp_path / "finger.urdf")
    STATES.write(tmp_path / "finger.urdf", learned_band(found))
    document = yaml.safe_load(file.read_text())
    for field, value in (("growth", float("nan")), ("spread", [1.0]), ("states", []), ("sizes", [[1.0]])):
        file.write_text(yaml.safe_dump(document | {field: value}))
        with refused(field):
            STATES.read(tmp_path / "finger.urdf")
