"""A task as a MuJoCo model: the exported scenario, with the options of a setting."""

import mujoco
import numpy as np

from soft_gripper.extras.export.mjcf import EXPLICIT_STEP, to_mjcf
from soft_gripper.fingers.finger_links import joint_name
from studies.peers.task import PeerTask, Setting


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
