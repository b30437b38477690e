"""Recordings of an arm that an independent script made up: its truth is found, and errors are what they are."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_hardware import ARM, ARM_NOMINAL, TRIALS, arm_bodies, arm_state, write_arm

from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.extras.hardware.replay import geometry_fit
from soft_gripper.extras.hardware.replay.arm_estimation import arm_recording
from soft_gripper.extras.hardware.replay.geometry_fit import fit_drive, fit_geometry
from soft_gripper.extras.hardware.replay.held_out import fit_arm, replay_inputs

DOWN = np.array([0.0, 0.0, 9.81])
FILES = [f"{trial}.txt" for trial in TRIALS]


def read(folder):
    return [arm_recording(one) for one in find_recordings(FILES, "two_segment_arm", folder)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_arm(tmp_path_factory.mktemp("two_segment_arm"))


@pytest.fixture(scope="module")
def trials(folder):
    return read(folder)


@pytest.fixture(scope="module")
def geometry(trials, arm_finger):
    return fit_geometry(trials[:4], arm_finger).model


def at_samples(truth, trial):
    """What an arm does at samples as wires, which are late, show them: held rows are up to 1/30 s old."""
    time = np.arange(0, 8.9, 0.01)
    return time, *arm_state(truth, trial, time)


def test_files_are_read_in_si_units_and_in_b(trials):
    """Every column where it belongs: pressures by chamber, wires by side, bodies by axis."""
    for arm in trials:
        time, pressure, bends, lengths = at_samples(ARM, arm.name)
        places, headings = arm_bodies(ARM, bends, lengths)
        rows = np.clip(np.round(arm.time / 0.01).astype(int) - 2, 0, len(time) - 1)  # held rows are 17 ms old, about
        late = np.clip(rows - 8, 0, None)
        assert arm.chamber_sections == (0, 0, 0, 1, 1, 1)
        assert np.abs(arm.pressures - pressure[late].reshape(-1, 6)).max() < 3e3
        assert np.abs(arm.positions - places[rows]).max() < 6e-3
        assert np.abs(arm.headings - headings[rows]).max() < 0.03
        inner, outer = np.diff(arm.inner, prepend=0.0), np.diff(arm.outer, prepend=0.0)
        offsets = np.array(ARM.wire_offsets)
        mean = (inner + outer) / 2 - offsets.mean(axis=1)
        assert np.abs(mean - lengths[late]).max() < 2e-3
        shown = (outer - inner - np.diff(offsets)[:, 0]) / ARM.spacing
        assert np.abs(shown[:, 0] - bends[late, 0]).max() < 0.03


# Of every number that is fitted: an arm that is off by so much in it, and in all else as nominal.
OFF = {
    "bend_offset": ({"wire_offsets": ((0.05, 0.05 + 0.04 * 0.043), (0.05, 0.05))}, -0.04),
    "crossing": ({"crossing": -0.04}, -0.04),
    "bow": ({"bow": 0.008}, 0.008),
    "coupling": ({"coupling": -0.006}, -0.006),
    "body_along": ({"bodies": (0.012, 0.0)}, 0.012),
    "body_across": ({"bodies": (0.006j, 0.0)}, 0.006),
    "turn": ({"turns": (0.06, 0.0)}, 0.06 * 40 / 0.06**2 / (40 / 0.06**2 + 1 / 0.05**2)),  # 40 samples, and a width
    "base": ({"base": -0.006}, -0.006),
    "tilt": ({"tilt": 0.04}, 0.04),
    "tilt back": ({"tilt": -0.04}, -0.04),
    "delay": ({"delay": 0.1}, 0.1),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", OFF)
def test_each_number_of_the_geometry_is_found_where_the_others_are_known(tmp_path, arm_finger, monkeypatch, kind):
    """With its sign, at its place, in its unit."""
    (changes, expected), name = OFF[kind], kind.split()[0]
    folder = write_arm(tmp_path, 6.0, replace(ARM_NOMINAL, **changes), trials=("trial_2", "trial_3"))
    arms = [arm_recording(one) for one in find_recordings(["trial_2.txt", "trial_3.txt"], "two_segment_arm", folder)]
    free = {name, "length_offset"}
    widths = {one: width if one in free else 1e-9 for one, width in geometry_fit._STDS.items()}
    monkeypatch.setattr(geometry_fit, "_STDS", widths)
    for of_all in {"base", "tilt", "delay"} - free:
        monkeypatch.setattr(geometry_fit, f"_{of_all.upper()}_STD", 1e-9)
    found = fit_geometry(arms, arm_finger).model
    wires, parts = found.wires, found.parts
    numbers = {
        "bend_offset": wires.bend_offsets[0],
        "crossing": wires.crossing[1],
        "bow": wires.bow[0],
        "coupling": parts.couplings[0].imag,
        "body_along": parts.bodies[0].real,
        "body_across": parts.bodies[0].imag,
        "turn": parts.turns[0],
        "base": parts.base.imag,
        "tilt": parts.tilt,
        "delay": found.delay,
    }
    weakly_seen = kind == "crossing"  # so that what is known beforehand, 0, draws it by a tenth
    assert numbers[name] == pytest.approx(expected, rel=0.12 if weakly_seen else 0.02)


def test_the_drive_is_the_true_one(trials, geometry, arm_finger, monkeypatch):
    monkeypatch.setattr(geometry_fit, "_RIDGE_SHARE", 1e-6)  # the usual one makes hardly used chambers weaker
    drive = fit_drive(trials[:4], geometry, arm_finger, DOWN)
    per_section = arm_finger.stiffness[0] / 6  # N m, of six joints
    gains = drive.gains[[0, -1]] / per_section
    np.testing.assert_allclose(gains[0, :2], ARM.bends[0][:2], rtol=0.02)
    np.testing.assert_allclose(gains[1, 3:5], ARM.bends[1][:2], rtol=0.02)
    assert (drive.finger.creep[0].share, drive.finger.creep[0].time) == ARM.creep
    of_noise = np.sqrt(2) * ARM.wire_noise / ARM.spacing / 6
    assert of_noise < drive.angle_std < 3 * of_noise  # weight, which the script leaves out, is the rest


def test_noise_of_the_wires_is_the_true_one(trials, arm_finger):
    """Of the extension ratio of a wire as long as the arm's mean."""
    noise = fit_arm(trials[:2], arm_finger, DOWN).arm.uncertainty.reading
    assert noise == pytest.approx(ARM.wire_noise / np.mean([arm.inner[:, -1].mean() for arm in trials[:2]]), rel=0.35)
    assert replay_inputs(trials[0], 0.0).wire_lengths[:, 0] == pytest.approx(trials[0].inner)
