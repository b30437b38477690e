"""Bands of an identified finger's markers: where it was fitted and beyond, and the file that keeps its states."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from here_executor import HereExecutor
from identified import recorded, release
from refusals import refused

from soft_gripper.extras.hardware.identification.confidence import kept_confidence
from soft_gripper.extras.hardware.identification.free_parameters import FingerFit, Model
from soft_gripper.extras.hardware.identification.identified_finger import compare_motions as compare_motions
from soft_gripper.extras.hardware.identification.identified_finger import identify
from soft_gripper.extras.hardware.identification.model_band import STATES, band_rows, extrapolations, learned_band
from soft_gripper.extras.hardware.identification.settled_states import IdentifiedStates, SettledStates, StateScore
from soft_gripper.extras.hardware.identification.settled_states import TestedStates as Compared
from soft_gripper.fingers.finger_parts import TipLoad
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


def loaded(beam, mass, seed):
    """A release under a load of some kg; its markers wander by 1 % of the displacement within 0.3 s."""
    load, rng = TipLoad(mass, 0.0, 0.0) if mass else None, np.random.default_rng(seed)
    motion = recorded(beam, replace(release(), name=f"{1e3 * mass:.0f} g", load=load))
    steps = rng.normal(0, 0.01 * motion.largest / np.sqrt(30), (2, len(motion.time) + 29, motion.markers.shape[1]))
    away = np.lib.stride_tricks.sliding_window_view(steps, 30, axis=1).sum(axis=-1)
    return replace(motion, markers=motion.markers + away[0] + 1j * away[1])


def test_bands_of_motions_know_what_the_keys_leave_open(beam):
    """A fit to the own weight alone hardly knows what the load weighs against; that is no error of the model."""
    true = beam.with_sections(lambda part: replace(part, youngs_modulus=1.1 * part.youngs_modulus))
    *fitted, between, beyond = [loaded(true, mass, seed) for seed, mass in enumerate((0.0, 0.05, 0.06, 0.1))]
    keys = ["youngs_modulus", "density", "relaxation_time", "creep.share", "marker_mass"]
    found = identify(beam, keys, fitted, [between, beyond], HereExecutor())
    kept, known = learned_band(found), kept_confidence(found.fit.free, found.confidence)
    assert kept.growth * np.sqrt(0.5) < 1.2 * kept.floor[0]
    rows = {row.recording: row for row in band_rows(kept, found, known)}
    assert rows.keys() == {"0 g", "50 g", "60 g", "100 g"}
    assert all(row.within_band_percent > 93 for row in rows.values())
    assert all(0.5 < rows[name].rms_z < 1.3 for name in ("0 g", "50 g", "60 g"))
    assert rows["100 g"].rms_z > 0.4, "beyond what was left out the band is wider by the root of 2"
    tested = compare_motions(found.model, [beyond], HereExecutor())
    (alone,) = band_rows(kept, tested, known)
    assert alone == rows["100 g"], "as beside the finger's file"
    (doubted,) = band_rows(kept, tested, replace(known, std=[10 * std for std in known.std]))
    assert doubted.band_mm > 1.5 * alone.band_mm


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
