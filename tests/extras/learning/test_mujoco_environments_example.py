"""Many environments in MuJoCo: what is estimated of each is near its true shape."""

import runpy
from pathlib import Path

import numpy as np
import pytest

EXAMPLE = Path(__file__).parents[3] / "examples" / "mujoco_environments.py"


@pytest.mark.slow
def test_every_environment_is_estimated():
    pytest.importorskip("mujoco")
    q, estimated = runpy.run_path(str(EXAMPLE))["main"](3)
    assert q.shape == estimated.shape == (3, 200, 12)
    assert np.ptp(q[:, -1].sum(axis=-1)) > np.radians(5)  # each has its own pressure
    assert np.abs(estimated[:, -1] - q[:, -1]).max() < np.radians(0.5)
