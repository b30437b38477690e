"""The tasks in MuJoCo."""

from time import process_time

import mujoco
import numpy as np

from peers.mujoco_model import angles_of, held_of, make_model
from peers.sensing import Sensing
from peers.task import Run, Setting, Task, Trial
from soft_gripper.fingers import forward_kinematics


def make_run(task: Task, setting: Setting) -> Run:
    """The model of the task; MuJoCo makes all steps of a period in one call."""
    model = make_model(task, setting)
    angles, substeps = angles_of(model, task), task.substeps(setting["step"])
    held = held_of(model)

    def run() -> Trial:
        data, states = mujoco.MjData(model), np.zeros((len(task.commands), model.nq))
        sensing = Sensing(task) if task.sensed else None
        start = process_time()
        for command, state in zip(task.commands, states, strict=True):
            data.ctrl[:] = command
            mujoco.mj_step(model, data, substeps)
            state[:] = data.qpos
            if sensing is not None:
                sensing.sample(state[angles], data.act)
        seconds = process_time() - start
        tips = forward_kinematics(states[:, angles], task.fingers[0].segment_length).tip
        return Trial(seconds, tips, states[:, held])

    return run
