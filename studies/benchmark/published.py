"""Quotes published numbers beside those of the benchmark: other bodies, sensors and contacts, so for scale only."""

from collections.abc import Set
from dataclasses import dataclass


@dataclass(frozen=True)
class Published:
    """A number that a source states."""

    tasks: tuple[str, ...]  # of the benchmark that it may be compared with
    value: str
    what: str
    source: str


PUBLISHED = (
    Published(
        ("contact_tip", "arm_tip", "trunk_shape"),
        "1.92 mm",
        "shape of a soft finger on hardware, from an array of strain sensors, learned in simulation",
        "KineSoft, arXiv 2503.01078",
    ),
    Published(
        ("contact_tip", "beam_tip"),
        "below 4 % of the length",
        "largest displacement error of a soft bar on hardware, from sparse strain sensors and a model",
        "Soft Robotics, doi 10.1089/soro.2024.0158",
    ),
    Published(
        ("beam_tip",),
        "2.1 % of the length",
        "shape of a tensegrity manipulator of 1.16 m on hardware, from inertial sensors on its struts",
        "arXiv 2603.05976",
    ),
    Published(
        ("arm_tip", "trunk_shape", "tendons_v4_tip", "tendons_v6_tip"),
        "0.91 mm (0.36 % of the length)",
        "shape of a two-segment tendon-driven robot on hardware, from one camera",
        "MoSSNet, arXiv 2303.00891",
    ),
    Published(
        ("contact_force", "contact_transverse", "contact_place"),
        "5.25 to 12.87 % of the force, 1.02 to 2.19 % of the location",
        "contacts on a continuum robot, from curvatures of fibre Bragg gratings and a rod model",
        "arXiv 2109.12469",
    ),
    Published(
        ("contact_force", "contact_transverse", "contact_place"),
        "8.7 mN (5.8 %), 1.7 mm (2.3 %)",
        "mean errors of contacts on a cable-driven robot on hardware, from tensions, shape and a network",
        "Soft Robotics, doi 10.1177/21695172251388808",
    ),
    Published(
        ("contact_force", "contact_transverse"),
        "0.17 N",
        "force that a finger with drifting soft sensors and a recurrent network exerts in closed loop, on hardware",
        "Soft Robotics, doi 10.1089/soro.2021.0012",
    ),
)


def comparable_numbers(tasks: Set[str]) -> list[Published]:
    """Published numbers that may be compared with one of these tasks."""
    return [number for number in PUBLISHED if not tasks.isdisjoint(number.tasks)]
