"""The tasks in MuJoCo: exported scenarios, with the options of a setting."""

from time import process_time

import mujoco
import numpy as np
from mujoco.rollout import rollout

from soft_gripper.extras.export.mjcf import EXPLICIT_STEP, to_mjcf
from soft_gripper.fingers import forward_kinematics
from soft_gripper.fingers.finger_links import joint_name
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


def make_model(task: PeerTask, setting: Setting) -> mujoco.MjModel:
    """The model under the options of a setting, with skins as stiff as its integrator requires."""
    step = setting["step"] if setting["integrator"] == "discrete" else min(setting["step"], EXPLICIT_STEP)
    exported = to_mjcf(task.scenario, step)
    meshes = {name: source.read_bytes() for name, source in exported.meshes.items()}
    spec = mujoco.MjSpec.from_string(exported.text, assets=meshes)
    _set_options(spec, task, setting)
    return spec.compile()


def angle_indices(model: mujoco.MjModel, task: PeerTask) -> np.ndarray:
    """Indices of the joint angles in qpos, (F, N)."""
    model_fingers = [(config.name, finger) for config, expanded in task.grippers for finger in expanded.fingers]
    return np.array(
        [
            [model.joint(f"{name}::{joint_name(f.name, i)}").qposadr[0] for i in range(f.segments)]
            for name, f in model_fingers
        ]
    )


def object_indices(model: mujoco.MjModel) -> np.ndarray:
    """Indices of the position of the free body in qpos, (3,); empty if there is none."""
    (free_joints,) = np.nonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    return np.concatenate([[], *(model.jnt_qposadr[joint] + np.arange(3) for joint in free_joints)]).astype(int)


def _set_options(spec: mujoco.MjSpec, task: PeerTask, setting: Setting) -> None:
    option = spec.option
    option.timestep = setting["step"]
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{setting['integrator'].upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{setting.get('cone', 'elliptic').upper()}")
    option.impratio = setting.get("impratio", 1)
    option.noslip_iterations = setting.get("noslip_iterations", 0)
    if not task.bodies:
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
