"""Loads weighed by the shape of a hanging finger, its tendons in pairs: a synthetic twin, and the published trunk."""

from dataclasses import replace

import numpy as np
import pytest
from hardware_files import published
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.extras.hardware.identification.confidence import (
    CONFIDENCE,
    ConfidenceConfig,
    confidence_of,
    kept_confidence,
)
from soft_gripper.extras.hardware.identification.free_parameters import FingerFit, Model, free_parameters
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.model_band import learned_band
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    fit_states,
    identify_states,
    marker_slopes,
    predicted_markers,
    resting_positions,
    settled_states,
    state_errors,
)
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.extras.hardware.weighing import KeptFit, learned_growth, weigh
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.paths import Tendon
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.scenario.model_files import model_path

SECTION = CrossSection(0.03, 0.03, 6e5, 600.0)
FREE = ["youngs_modulus", "tendon.lever", "tendon.slack"]
NOISE = 3e-4  # m
WINDOW = 30.0  # s


def trunk(modulus=6e5, lever=0.012, slacks=(-1e-3, 5e-4, -5e-4, 1e-3)):
    """Two pairs to the end of a finger that hangs down, and slack in some."""
    places = [(lever, 0.0), (0.0, lever), (-lever, 0.0), (0.0, -lever)]
    tendons = [
        Tendon(name, (x,), (y,), stiffness=2e3, slack=slack)
        for name, (x, y), slack in zip(["a", "b", "back_a", "back_b"], places, slacks, strict=True)
    ]
    section = replace(SECTION, youngs_modulus=modulus)
    ways = ("bending", "sideways", "twist")
    return Finger("trunk", 0.3, section, section, 0.02, segments=6, yields=ways, tendons=tuple(tendons))


TRUE, GUESS = trunk(), trunk(8e5, 0.0135, (0.0,) * 4)


def states_of(load, seed, rows=300):
    """Smooth random motion of both motors in 60 s, a marker in the middle and one at the tip; noise lasts 1 s."""
    random = np.random.default_rng(seed)
    time = np.linspace(0, 60, rows)
    phases, rates = random.uniform(0, 2 * np.pi, (2, 5)), random.uniform(0.5, 3, (2, 5))
    wound = 4e-3 * np.sin(rates * time[:, None, None] + phases).sum(axis=-1) / 2
    pulled = np.concatenate([wound, -wound], axis=1)
    none = np.zeros((rows, 2, 3))
    families = np.where(time < 30, "block 1", "block 2")
    at = np.array([0.5, 1.0])
    states = SettledStates(
        f"hung_{1e3 * load:.0f}g", pulled, none, none[0], families, np.array([0, 0, 9.81]), at, load, time
    )
    markers, _ = predicted_markers(TRUE, states, resting_positions(Model(TRUE), states))
    noise = np.repeat(random.normal(0, NOISE, (rows // 10, 2, 3)), 10, axis=0)
    return replace(states, markers=markers + np.array([0.1, 0.0, -0.02]) + noise)


@pytest.fixture(scope="module")
def fitted():
    recordings = [states_of(0.0, 1), states_of(0.1, 2)]
    free = free_parameters(GUESS, FREE, [])
    return fit_states(free, recordings, [of.families == "block 1" for of in recordings]).model.finger


@pytest.mark.slow
def test_what_made_the_states_is_found_with_one_known_mass(fitted):
    """The modulus by the mass; without it there is only its ratio to the weight."""
    assert fitted.base.youngs_modulus == pytest.approx(6e5, rel=0.05)
    assert fitted.tendons[0].x[0] == pytest.approx(0.012, rel=0.02)
    np.testing.assert_allclose(
        [tendon.slack for tendon in fitted.tendons], [tendon.slack for tendon in TRUE.tendons], atol=3e-4
    )


@pytest.mark.slow
@pytest.mark.parametrize("load", [0.0, 0.06, 0.2])
def test_other_loads_are_weighed_within_their_bands(fitted, load):
    """Each window within 1.5 bands of 95 %, and the bands are neither empty nor as wide as the load."""
    *windows, whole = weigh(Model(fitted), states_of(load, 3), WINDOW)
    assert [row.rows for row in windows] == [150, 150]
    for row in (*windows, whole):
        assert abs(row.load_g - 1e3 * load) < 1.5 * row.band_g
        assert 0.1 < row.band_g < 6
    assert whole.named_g == 1e3 * load
    assert whole.band_g < max(row.band_g for row in windows)


@pytest.mark.slow
def test_bands_cover_what_they_say(fitted):
    """Over noise that lasts 10 rows: a band for independent rows would be three times as narrow, and cover half."""
    rows = [row for seed in range(10, 30) for row in weigh(Model(TRUE), states_of(0.08, seed), WINDOW)[:-1]]
    covered = np.mean([abs(row.load_g - 80) < row.band_g for row in rows])
    assert 0.8 < covered <= 1.0
    spread = np.std([row.load_g for row in rows])
    assert 1.2 * spread < np.mean([row.band_g for row in rows]) < 3 * spread


def test_a_load_between_two_known_ones_with_tendons_that_lead():
    """As of the trunk with DC motors: fitted with two loads, and weighed with the delay of its set-up."""

    def late(load, seed):
        states = states_of(load, seed, rows=200)
        every, whole = slice(None, None, 5), (states.time, states.pulled)
        states = replace(
            states,
            **{name: getattr(states, name)[every] for name in ("pulled", "markers", "families", "time")},
            winding=whole,
        )
        q = resting_positions(Model(TRUE, Setup(delay=-0.4)), states)
        noise = np.random.default_rng(seed).normal(0, NOISE, states.markers.shape)
        return replace(states, markers=predicted_markers(TRUE, states, q)[0] + noise)

    free = free_parameters(trunk(8e5), ["youngs_modulus", "delay"], [])
    known = [late(0.2, 1), late(0.4, 2)]
    model = fit_states(free, known).model
    assert model.setup.delay == pytest.approx(-0.4, abs=0.02)
    *_, whole = weigh(model, late(0.3, 3), WINDOW)
    assert abs(whole.load_g - 300) < 1.5 * whole.band_g < 15
    *_, prompt = weigh(Model(model.finger), late(0.3, 3), WINDOW)
    assert prompt.band_g > 2 * whole.band_g


SCALES = ["youngs_modulus", "density", "tendon.stiffness"]  # six numbers: the shape does not change with all of them


def kept(states, std, growth=0.0):
    """What is kept of a fit to states that left the scale of all forces open, by a deviation of its logarithm."""
    confidence = ConfidenceConfig(SCALES, [std] * 6, np.ones((6, 6)).tolist(), growth)
    at = np.column_stack([states.pulled, np.full(len(states.pulled), states.load)]).tolist()
    names = [*(f"{i} [m]" for i in range(4)), "load [kg]"]
    return KeptFit(FittedStatesConfig(names, [1e-3] * 4 + [0.1], at, [1.0], growth=1.0), confidence)


def test_a_scale_that_the_fit_leaves_open_is_in_the_band():
    """By as much of the load as of the scale; the changes by the six keys cancel but for that, which costs some %."""
    states = states_of(0.1, 3, rows=20)
    (*_, exact), (*_, whole) = (weigh(Model(TRUE), states, 60.0, None, fit) for fit in (None, kept(states, 0.2)))
    assert whole.band_g == pytest.approx(np.hypot(exact.band_g, 1.96 * 0.2 * exact.load_g), rel=0.1)
    assert (whole.load_g, whole.far_percent) == (exact.load_g, 0.0)


def test_bands_widen_away_from_the_shapes_that_were_fitted():
    """And with a load that is heavier than all of them, but not between two of them; units of 1 mm and of 100 g."""
    states = states_of(0.4, 3, rows=20)
    light, heavy = (kept(replace(states, load=load), 0.0, 2.0) for load in (0.1, 0.7))
    both = light._replace(states=replace(light.states, states=light.states.states + heavy.states.states))
    away = kept(replace(states, load=0.4, pulled=states.pulled + np.array([1.0, 0, 0, 0])), 0.0, 2.0)
    exact, *found = (weigh(Model(TRUE), states, 60.0, None, fit)[-1] for fit in (None, light, both, away))
    expected = exact.band_g * np.sqrt(1 + 4 * np.array([3.0, 0.0, 1000.0]))
    np.testing.assert_allclose([row.band_g for row in found], expected, rtol=0.01)
    assert [row.far_percent for row in found] == [100, 100, 100]


def fit_of(model, recordings):
    """A fit that ended at a model."""
    free = free_parameters(model.finger, ["youngs_modulus", "tendon.lever"], [])
    errors = tuple(state_errors(model, of) for of in recordings)
    slopes = [marker_slopes(free, free.start, of, np.full(len(of.pulled), True)) for of in recordings]
    left = np.concatenate(errors).ravel()
    weights = (1 + (left / (0.02 * model.finger.length)) ** 2) ** -0.25
    numbers = free.start, left, np.concatenate(slopes), weights, 0.0, 0.0, True
    fit = FingerFit(free.build_model, *numbers, free, tuple(recordings))
    return IdentifiedStates(model, tuple(recordings), errors, (), errors, fit, None)


def test_the_growth_of_the_band_is_that_by_which_regions_left_out_are_weighed():
    """Least where the model is exact; more where tendons are slack that it takes for tight. None without a load."""
    recordings = [states_of(load, 1, rows=120) for load in (0.1, 0.2)]
    exact, wrong = (learned_growth(fit_of(Model(of), recordings)) for of in (TRUE, trunk(slacks=(0.0,) * 4)))
    assert wrong > 1.5 * exact > 0
    assert learned_growth(fit_of(Model(TRUE), [replace(recordings[0], load=0.0)])) == 0.0


def test_the_confidence_beside_a_finger_is_that_of_the_fit(tmp_path):
    assert CONFIDENCE.read(tmp_path / "finger.urdf") is None
    free = free_parameters(TRUE, SCALES, [])
    random = np.random.default_rng(0)
    found = confidence_of(free, free.start, random.normal(size=90), random.normal(size=(90, 6)), 1.0)
    config = kept_confidence(free, found)
    np.testing.assert_allclose(config.covariance, found.covariance, rtol=1e-3, atol=1e-7)
    CONFIDENCE.write(tmp_path / "finger.urdf", config)
    assert CONFIDENCE.read(tmp_path / "finger.urdf") == config
    CONFIDENCE.write(tmp_path / "finger.urdf", replace(config, std=[1.0]))
    with refused("correlation"):
        CONFIDENCE.read(tmp_path / "finger.urdf")


def test_a_tare_in_disorder_is_the_same():
    """What counts is how the tendons were pulled, and not when."""
    empty, loaded = states_of(0.0, 5), states_of(0.08, 5)
    order = np.random.default_rng(0).permutation(len(empty.pulled))
    mixed = replace(empty, pulled=empty.pulled[order], markers=empty.markers[order])
    found = [weigh(Model(TRUE), loaded, WINDOW, tare) for tare in (empty, mixed)]
    np.testing.assert_allclose([row.load_g for row in found[0]], [row.load_g for row in found[1]])


def test_another_motion_is_no_tare():
    other = replace(states_of(0.0, 5), pulled=states_of(0.0, 5).pulled + 1.0)
    with refused("--tare"):
        weigh(Model(TRUE), states_of(0.08, 5), WINDOW, other)


@pytest.mark.slow
def test_what_is_refused(fitted):
    states = states_of(0.06, 4, rows=40)
    with refused("time"):
        weigh(Model(fitted), replace(states, time=None), WINDOW)
    with refused("--window", 0.0):
        weigh(Model(fitted), states, 0.0)
    with refused("--window", 3.0):
        weigh(Model(fitted), states, 3.0)
    with refused("tip_load"):
        weigh(Model(replace(fitted, tip_load=TipLoad(0.1, 0.0, 0.0))), states, WINDOW)


HEADER = "ID,x1,y1,z1,x2,y2,z2,x3,y3,z3,phi1,phi2,phi3,phi4,phi5,phi6"


def written(folder, angles, name="made_100g.csv"):
    """A file like those of the trunk, the disks straight below each other."""
    disks = "0.1,-0.108,0.105,0.1,-0.2,0.105,0.1,-0.3125,0.105"
    rows = [f"{i},{disks},{','.join(f'{angle:.3f}' for angle in row)}" for i, row in enumerate(angles)]
    (folder / name).write_text("\n".join([HEADER, *rows]) + "\n")
    return folder / name


def test_a_motor_winds_a_pair(tmp_path):
    """By opposite lengths; one of 60 rows is used, and they form two blocks."""
    angles = np.outer(np.arange(600) / 6, np.arange(1, 7))
    (recording,) = find_recordings([str(written(tmp_path, angles))], "soft_trunk")
    finger = read_finger(model_path(load_description("soft_trunk").finger))
    states = settled_states(recording, finger)
    np.testing.assert_allclose(states.pulled[:, :6], np.radians(angles[::60]) * 0.02)
    np.testing.assert_allclose(states.pulled[:, 6:], -states.pulled[:, :6])
    np.testing.assert_allclose(states.time, np.arange(0, 6, 0.6))
    np.testing.assert_allclose(states.markers[0, :, 2], [0.108, 0.2, 0.3125])
    assert states.load == 0.1
    assert list(states.families) == ["block 1"] * 5 + ["block 2"] * 5


PUBLISHED_FREE = ["density", "youngs_modulus", "tendon.lever", "tendon.angle", "tendon.slack", "tendon.stiffness"]


def rows_of(states, rows):
    """Some rows of a recording, none of which is left out of a fit."""
    kept = {name: getattr(states, name)[rows] for name in ("pulled", "markers", "time")}
    return replace(states, **kept, families=np.full(int(rows.sum()), ""))


@pytest.mark.published
def test_the_published_trunk_with_dc_motors():
    """As the page on identification states: tip of blocks left out within 15 mm, both loads within their bands.

    And so are blocks, of which two recordings have five, each weighed by a fit without it.
    """
    folder = published("trunk_dc")
    files = [str(folder / f"observations_{mass}g.csv") for mass in (200, 400)]
    finger = read_finger(model_path(load_description("trunk_dc").finger))
    states = [settled_states(recording, finger) for recording in find_recordings(files, "trunk_dc")]
    keys = [*PUBLISHED_FREE, "delay", "backlash"]
    with open_executor(None, None) as executor:
        found = identify_states(finger, keys, states, [], executor)
    mean = {(row.recording, row.role, row.family): row.mean_mm for row in found.scores if row.marker == "3"}
    left_out = [mean[of.name, "left out", "all"] for of in states]
    assert np.mean(left_out) < 15
    for of, named in zip(states, (200, 400), strict=True):
        *_, whole = weigh(found.model, of, WINDOW)
        assert abs(whole.load_g - named) < min(whole.band_g, 30)
    held = []
    for block in sorted(set(states[0].families)):
        others = [rows_of(of, of.families != block) for of in states]
        without = identify_states(found.model.finger, keys, others, [], HereExecutor(), setup=found.model.setup)
        confidence = kept_confidence(without.fit.free, without.confidence, learned_growth(without))
        fit = KeptFit(learned_band(without), confidence)
        for of in states:
            *_, whole = weigh(without.model, rows_of(of, of.families == block), WINDOW, None, fit)
            held.append(abs(whole.load_g - whole.named_g) < whole.band_g)
    assert np.mean(held) >= 0.9
