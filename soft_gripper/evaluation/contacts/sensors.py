"""The sensors with which the evaluations estimate contacts, and what they are called."""

from soft_gripper.sensors.measurement import MeasurementModel

# Sections and where they meet, as shares of the length. A force near by bends the first of two sections alone, and
# one reading does not tell force from place: so the first is made the shorter one, beside the same number equally long.
LAYOUTS: tuple[tuple[int, tuple[float, ...] | None], ...] = ((2, None), (2, (1 / 3,)), (4, None))


def describe_borders(layout: MeasurementModel) -> str:
    """Where the sections meet, in mm from the base, for tables."""
    return " ".join(f"{1e3 * end:g}" for end in layout.rest_lengths.cumsum()[:-1])
