"""Additions of this extra to scenarios: a monitor of fingers and sensors before their estimator."""

from dataclasses import dataclass


@dataclass
class Watched:
    """An estimator of fingers that may be faulty."""

    health: bool = False  # name faults of fingers and sensors, and drop faulty sensors


FIELDS = {"EstimatorConfig": Watched}
REPORTS = {"health": "soft_gripper.extras.health.health_monitor:named_faults"}
MONITORS = {"health": "soft_gripper.extras.health.health_monitor:make_monitor"}
