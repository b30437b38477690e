"""Warnings of MuJoCo: logged, but for those of states that diverge, and not written to a file."""

import numpy as np
import pytest

from soft_gripper.extras.mujoco_engine.library import load_mujoco

mujoco = pytest.importorskip("mujoco")

BALL = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'


def test_a_state_that_diverges_leaves_no_file(tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    load_mujoco()
    model = mujoco.MjModel.from_xml_string(BALL)
    data = mujoco.MjData(model)
    data.qvel[:] = np.nan
    mujoco.mj_step(model, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQVEL].number == 1
    mujoco.get_mju_user_warning()("memory is full")
    assert caplog.messages == ["memory is full"]
    assert list(tmp_path.iterdir()) == []
