"""Difference: an estimate less the truth."""

from collections.abc import Sequence
from typing import Any

from soft_gripper.array_block import ArrayBlock


class Difference(ArrayBlock):
    """Says by how much an estimate is off.

    ::

        estimate (n) ---> +------------+
                          | Difference | ---> difference (n)
        truth (n) ------> +------------+
    """

    def __init__(self, size: int, unit: str, **axes: Sequence[Any]):
        """Of vectors with so many entries; unit and axes as for `describe`."""
        super().__init__()
        self.take("estimate", size)
        self.take("truth", size)
        self.put_out("difference", lambda estimate, truth: estimate - truth, "estimate", "truth", unit=unit, **axes)
