"""Line on the changes of a finger since its calibration: bend, %, and offsets of its readings."""

from collections.abc import Callable

import numpy as np

from soft_gripper.arrays import Array


def changes_line(finger: str, read: Callable[[str], Array]) -> str:
    """Changes that `recursive` has found of a finger, see `recursive.Changes`; `read` reads a signal by its name."""
    bend, std = (100 * float(np.ravel(read(f"{finger}.{name}"))[0]) for name in ("bend_change", "bend_change_std"))
    offsets, stds = (np.ravel(read(f"{finger}.{name}")) for name in ("offset_changes", "offset_changes_std"))
    largest = int(np.abs(offsets).argmax())
    offset_text = f"offsets have moved by up to {offsets[largest]:+.2g} +- {stds[largest]:.2g}"
    return f"{finger}: bends {bend:+.1f} +- {std:.1f} % further than its model; {offset_text}"
