"""A finger with textbook solutions, and short runs of the shipped free bending."""

from collections.abc import Sequence
from dataclasses import astuple, replace

import numpy as np

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

LENGTH = 0.12  # m
BENDING_STIFFNESS = 0.01  # N m^2


def uniform_finger(segments: int, relaxation_time: float = 0.015) -> Finger:
    """A beam of constant cross-section, LENGTH long and of BENDING_STIFFNESS."""
    section = CrossSection(0.02, 0.02, 1.0, 1100.0, chamber_width=0.012, chamber_thickness=0.008, chamber_center=-5e-3)
    section = replace(section, youngs_modulus=BENDING_STIFFNESS / float(section.bending_stiffness))
    return Finger("finger", LENGTH, section, section, 0.018, segments, relaxation_time)


def built_at(finger: Finger, s: float) -> CrossSection:
    """The cross-section at `s` m from the base: every number of what it is built of is linear from base to tip."""
    base, tip = np.array([astuple(finger.base), astuple(finger.tip)])
    return CrossSection(*(base + (tip - base) * s / finger.length))


def free_bending(pressures: Sequence[float], step_duration: float, *overrides: str) -> Scenario:
    """The shipped free bending with other pressures, Pa, each for `step_duration` s, a multiple of 10 ms."""
    short = (
        f"pressure.steps.all={list(pressures)}",
        f"pressure.settle={step_duration - 0.01}",
        "pressure.hold_samples=1",
    )
    return load_scenario("free_bending", [*short, *overrides])
