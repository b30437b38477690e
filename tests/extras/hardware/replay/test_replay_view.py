"""What of a replay is in Meshcat."""

import numpy as np
import xarray as xr
from pydrake.geometry import Meshcat

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.hardware.replay.view import show_replays


def test_bodies_and_estimates_are_shown():
    time = np.arange(0, 1, 0.02)
    bodies = np.tile([[0.0, 0.1], [0.02, 0.2]], (len(time), 1, 1))
    joints = np.tile(np.column_stack([np.zeros(4), np.linspace(0.02, 0.17, 4)]), (len(time), 1, 1))
    data = {
        "measured_bodies": (("time", "body", "xz"), bodies),
        "arcs 2.joint_positions": (("time", "joint", "xz"), joints),
        "arcs 2.body_positions": (("time", "body", "xz"), bodies),
    }
    recording = Recording(xr.Dataset(data, {"time": time, "body": ["middle", "tip"]}))
    meshcat = Meshcat()
    show_replays(meshcat, [recording, recording], {"arcs 2": "#0072b2"})
    for path in ("replay/measured/1", "replay/arcs_2/0", "replay/arcs_2/4"):
        assert meshcat.HasPath(path)
    assert not meshcat.HasPath("replay/arcs_2/5")
