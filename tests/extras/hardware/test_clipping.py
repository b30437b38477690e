"""Readings that are clipped or dead, and those of a finger at rest, which are neither."""

import numpy as np
import pytest

from soft_gripper.extras.hardware.clipping import stuck_readings

LEVELS = 0, 40, 80, 120, 150, 110, 70, 30, 0, 60, 120, 60, 0  # kPa
STROKES = -60, 900, 800  # counts at 150 kPa: one side hardly stretches


def bending(rest=0, noise=2.0, quantum=1.0):
    """Counts of three sensors, and the pressure, in steps; before them the finger rests for a number of samples."""
    steps = [np.append(np.linspace(p, q, 10), np.full(20, q)) for p, q in zip((0, *LEVELS), LEVELS, strict=False)]
    pressure = np.concatenate([np.zeros(rest), *steps])
    lag = np.convolve(np.pad(pressure, (20, 0), mode="edge"), np.full(8, 1 / 8), "full")[20 : 20 + len(pressure)]
    bend = (lag / 150) ** 1.2
    drawn = noise * np.random.default_rng(1).standard_normal((len(pressure), len(STROKES)))
    counts = quantum * np.round(
        (2048 + np.outer(bend, STROKES) + drawn * (np.arange(len(bend)) >= rest)[:, None]) / quantum
    )
    return counts, pressure


def stuck(counts, pressure):
    readings = {f"reading {i}": reading for i, reading in enumerate(counts.T)}
    return [(each.name, each.question) for each in stuck_readings(readings, {"pressure": pressure})]


@pytest.mark.parametrize("share", [0.2, 0.3, 0.5])
@pytest.mark.parametrize("word", ["largest", "smallest"])
@pytest.mark.parametrize("reading", [1, 2])
def test_a_clipped_reading_is_questioned(reading, word, share):
    counts, pressure = bending()
    if word == "largest":
        counts[:, reading] = np.minimum(counts[:, reading], np.quantile(counts[:, reading], 1 - share))
    else:  # far enough that it is not the end of its motion
        counts[:, reading] = np.maximum(counts[:, reading], np.quantile(counts[:, reading], share + 0.3))
        share = np.mean(counts[:, reading] == counts[:, reading].min())
    ((name, question),) = stuck(counts, pressure)
    assert name == f"reading {reading}"
    found = question.partition(f"has its {word} value in ")[2].partition(" % of the samples: is it clipped?")[0]
    assert float(found) == pytest.approx(100 * share, abs=2)


def test_a_glitch_does_not_hide_that_a_reading_is_clipped():
    counts, pressure = bending()
    counts[:, 1] = np.minimum(counts[:, 1], np.quantile(counts[:, 1], 0.7))
    counts[50, 1] = 65535
    assert [name for name, _ in stuck(counts, pressure)] == ["reading 1"]


@pytest.mark.parametrize("quantum", [1, 20, 100])
@pytest.mark.parametrize("noise", [0, 2])
@pytest.mark.parametrize("rest", [0, 300, 3000])
def test_a_finger_at_rest_is_not_clipped(rest, noise, quantum):
    """It stays exactly at the end of its range for up to 90 % of a recording, however coarse its readings are."""
    assert stuck(*bending(rest, noise, quantum)) == []


def test_a_reading_that_never_moves_is_questioned():
    counts, pressure = bending()
    counts[:, 2] = 7
    assert stuck(counts, pressure) == [("reading 2", "never changes, and others do: is it connected?")]
    assert stuck(np.full((100, 3), 7.0), np.arange(100.0)) == []
