"""Made-up recordings of an arm whose geometry and drive are known."""

import numpy as np
import pytest

from soft_gripper.extras.hardware.replay.arm_estimation import PERIOD, ArmRecording, RigidParts, stretched_arm
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY

SPACING = 0.043
PARTS = RigidParts(0.002j, 0.02, np.array([0.003j, 0]), np.array([0.01 + 0.002j, 0.02]), np.array([0.02, -0.01]))
PRESSURES = np.array([[1e5, 0, 1e5, 0], [1e5, 0, 0, 1e5], [0, 1e5, 1e5, 0], [0, 1e5, 0, 1e5]])  # Pa, by recording
BEND = 6e-6  # rad/Pa of a section, positive under its first chamber


@pytest.fixture(scope="session")
def arm_finger():
    """The finger that stands for the published arm."""
    (finger,) = expand_urdf(DIRECTORY / "recordings/two_segment_arm.urdf").fingers
    return finger


@pytest.fixture(scope="session")
def arms(arm_finger):
    """Four recordings of 6 s: both sections bend either way within a second, and lengthen."""
    return [make_recording(f"run_{i}", pressures, arm_finger) for i, pressures in enumerate(PRESSURES)]


def make_recording(name, held, finger):
    time = np.arange(0, 6, PERIOD)
    pressures = np.minimum(time, 1)[:, None] * held
    theta = BEND * (pressures[:, [0, 2]] - pressures[:, [1, 3]])
    length = np.array([0.12, 0.13]) + 0.02 * np.minimum(time, 1)[:, None]
    ends = finger.section_ends(2)
    q = np.repeat(theta / np.diff(ends), np.diff(ends), axis=-1)
    _, positions, headings = stretched_arm(PARTS, q, length, ends)
    noise = np.random.default_rng(int(name[-1])).normal(0, 1e-4, (2, len(time), 2))
    inner = (length - theta * SPACING / 2).cumsum(axis=1) + [0.10, 0.05] + noise[0]
    outer = (length + theta * SPACING / 2).cumsum(axis=1) + [0.101, 0.047] + noise[1]
    bodies, chambers = ("middle", "tip"), (0, 0, 1, 1)
    return ArmRecording(name, SPACING, time, inner, outer, pressures, chambers, bodies, positions, headings)
