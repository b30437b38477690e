"""Recordings of a beam and a segment that an independent script made up: simulated with their truth, scored, fitted."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_hardware import BEAM, BEAM_LOADS, beam_motion, write_beam

from soft_gripper.extras.hardware.identification.fit import score
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.simulated_motion import measured_motion
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.models import DIRECTORY

SEGMENTS = 6  # of the chain; its error falls with their square, to 1 % here
DURATION = 1.5  # s, of the beam


@pytest.fixture(scope="module")
def beams(tmp_path_factory):
    return write_beam(tmp_path_factory.mktemp("clamped_beam"), DURATION)


def motion_of(folder, file, description):
    (recording,) = find_recordings([f"{file}.csv"], description, folder)
    return measured_motion(recording)


def of_truth(description, truth, **changes):
    finger = replace(read_finger(DIRECTORY / f"recordings/{description}.urdf"), segments=SEGMENTS)
    ends = {end: replace(getattr(finger, end), youngs_modulus=truth.youngs_modulus) for end in ("base", "tip")}
    creep = tuple(CreepBranch(*branch) for branch in truth.creep)
    return replace(finger, **ends, creep=creep, relaxation_time=truth.relaxation_time, **changes)


def true_beam(truth=BEAM):
    return Model(of_truth("clamped_beam", truth))


def swings(time, along):
    """Frequency and logarithmic decrement by the first extrema of a finely sampled motion, from peak to peak."""
    steps = np.diff(along)
    k = np.flatnonzero(steps[1:] * steps[:-1] < 0) + 1
    k = k[time[k] > 0.01]  # up to the release there is rounding alone
    k = k[np.append(True, np.abs(np.diff(along[k])) > 0.04)][:9]
    half = np.polyfit(range(len(k)), time[k], 1)[0]
    return 0.5 / half, -2 * np.polyfit(range(len(k) - 1), np.log(np.abs(np.diff(along[k]))), 1)[0]


@pytest.mark.parametrize("name", BEAM_LOADS)
def test_a_beam_of_known_modulus_moves_as_the_independent_one(beams, name):
    motion = motion_of(beams, name, "clamped_beam")
    i, load = list(BEAM_LOADS).index(name), BEAM_LOADS[name]
    released = BEAM.released + 0.13 * i
    assert motion.events[0] == pytest.approx(released, abs=0.1)
    assert (motion.load.mass if motion.load else 0.0) == pytest.approx(load)
    found = score(true_beam(), motion.with_unknowns(np.array([released, released + BEAM.lets_go])), "test")
    place, heading = beam_motion(BEAM, load, np.arange(0, DURATION, 0.001), released)
    assert found.motion_error_mm < 0.02 * 1e3 * np.abs(place - 0.1).max()
    assert found.tip_error_percent < 1.0
    time = np.arange(0, DURATION, 0.001) - released
    for turn in (found.settled_turn_deg, found.simulated_settled_turn_deg):
        assert turn == pytest.approx(np.degrees(heading[-200:].mean()), rel=0.02)
    # of the middle of the markers, along where it settles
    markers = np.mean([0.013j, 0.001 + 0.002j, -0.002 - 0.012j])
    away = place + np.exp(1j * heading) * markers - 0.1 - markers
    rests = away[-200:].mean()
    frequency, decrement = swings(time, (away * np.conj(rests)).real / abs(rests) ** 2)
    assert [found.frequency_hz, found.simulated_frequency_hz] == pytest.approx([frequency] * 2, rel=0.02)
    assert [found.decrement, found.simulated_decrement] == pytest.approx([decrement] * 2, rel=0.05)
