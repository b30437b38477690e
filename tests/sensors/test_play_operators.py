"""Play operators: loops as wide as they should be, whatever the stroke, however fast, and closed."""

import numpy as np
import pytest

from soft_gripper.sensors.strain_errors import (
    FULL_SCALE,
    HYSTERESIS_LIMIT,
    PLAYS,
    RADII,
    StrainErrors,
    disturb,
    lagging_strain,
    moved_plays,
)

WIDTH = 0.02  # of the stroke


def lag(strain, width=WIDTH):
    """The strain with hysteresis along a path, (T,)."""
    plays, found = np.zeros((PLAYS, 1)), []
    for value in strain[:, None]:
        plays = moved_plays(plays, value)
        found.append(lagging_strain(plays, value, width)[0])
    return np.array(found)


def cycle(low, high, samples=2000):
    """Up, down and up again."""
    up = np.linspace(low, high, samples + 1)
    return np.concatenate([up, up[-2::-1], up[1:]])


def loop(low, high, samples=2000, width=WIDTH):
    """The strain with hysteresis on the way down and on the way up again, both by growing strain."""
    found = lag(cycle(low, high, samples), width)
    return found[samples : 2 * samples + 1][::-1], found[2 * samples :]


@pytest.mark.parametrize("width", [WIDTH, HYSTERESIS_LIMIT])
@pytest.mark.parametrize(("low", "high"), [(0.0, 0.1), (-0.2, 0.3), (0.05, 0.07)])
def test_the_loop_is_as_wide_as_its_share_of_the_stroke(low, high, width):
    """Less twice the least radius; on unloading, more is read than on loading."""
    down, up = loop(low, high, width=width)
    stroke = high - low
    assert (down - up).max() == pytest.approx(width * (stroke - 2 * RADII.min()), rel=1e-3)
    assert (down - up).max() == pytest.approx(width * stroke, rel=0.05)
    assert (down - up).min() > -1e-12


def test_at_the_limit_readings_still_follow_a_small_reversal():
    found = lag(np.array([0.0, 0.1, 0.1 - 1e-5, 0.1 + 1e-5]), HYSTERESIS_LIMIT)
    assert found[2] < found[1] < found[3]
    assert pytest.approx(1 / np.maximum(1 - RADII / FULL_SCALE, 0).sum(), rel=0.02) == HYSTERESIS_LIMIT


def test_first_stretched_to_full_scale_a_sensor_reads_it():
    assert lag(np.linspace(0, FULL_SCALE, 100))[-1] == pytest.approx(FULL_SCALE, abs=1e-12)


def test_a_recording_has_the_same_loop():
    strain = cycle(0.0, 0.1, 200)
    found = disturb(StrainErrors(hysteresis=WIDTH), 1 + strain[:, None], 0.01, np.random.default_rng(1))
    np.testing.assert_allclose(found[:, 0], 1 + lag(strain), rtol=0, atol=1e-14)
