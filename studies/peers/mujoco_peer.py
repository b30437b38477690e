"""The tasks in MuJoCo."""

from time import process_time

import mujoco
import numpy as np
from mujoco.rollout import rollout

from soft_gripper.fingers import forward_kinematics
from studies.peers.mujoco_model import angle_indices, make_model, object_indices
from studies.peers.sensing import sense
from studies.peers.task import PeerTask, PeerTrial, Run, Setting

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS  # time, qpos, qvel, act


def make_run(task: PeerTask, setting: Setting) -> Run:
    """The model of the task; MuJoCo makes all steps of the run in one call."""
    model = make_model(task, setting)
    angles, substeps = angle_indices(model, task), task.substeps(setting["step"])
    object_columns = object_indices(model)
    begin = np.zeros(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, mujoco.MjData(model), begin, _STATE)

    def run() -> PeerTrial:
        data, control = mujoco.MjData(model), np.repeat(task.commands, substeps, axis=0)
        start = process_time()
        states, _ = rollout(model, data, begin[None], control[None])
        sampled = states[0, substeps - 1 :: substeps, 1:]
        qpos, act = sampled[:, : model.nq], sampled[:, model.nq + model.nv :]
        if task.sensed:
            sense(task, qpos[:, angles], act)
        seconds = process_time() - start
        tips = forward_kinematics(qpos[:, angles], task.fingers[0].segment_length).tip
        return PeerTrial(seconds, tips, qpos[:, object_columns])

    return run
