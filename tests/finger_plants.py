"""A finger with textbook solutions, and short runs of the shipped free bending."""

from collections.abc import Sequence

from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.fingers.finger import CrossSection, Finger

LENGTH = 0.12  # m
BENDING_STIFFNESS = 0.01  # N m^2, E I = 7.5e5 Pa * 0.02 m * (0.02 m)^3 / 12


def uniform_finger(segments: int, relaxation_time: float = 0.015) -> Finger:
    """A beam of constant cross-section, LENGTH long and of BENDING_STIFFNESS."""
    section = CrossSection(
        width=0.02,
        thickness=0.02,
        youngs_modulus=7.5e5,
        density=1100.0,
        chamber_area=1e-4,
        chamber_eccentricity=8e-3,
    )
    return Finger("finger", LENGTH, section, section, 0.018, segments, relaxation_time)


def free_bending(pressures: Sequence[float], step_duration: float, *overrides: str) -> Scenario:
    """The shipped free bending with other pressures, Pa, each for `step_duration` s, a multiple of 10 ms."""
    short = (
        f"pressure.steps.all={list(pressures)}",
        f"pressure.settle={step_duration - 0.01}",
        "pressure.hold_samples=1",
    )
    return load_scenario("free_bending", [*short, *overrides])
