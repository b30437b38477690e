"""Many grasps at once in MuJoCo, on all cores, with the readings and estimates that this gripper has of each.

pip install 'soft-gripper[mujoco]'; python examples/mujoco_environments.py [ENVIRONMENTS]
"""

import os
import sys

import mujoco
import numpy as np
from mujoco.rollout import rollout

import soft_gripper as sg

SECONDS, PERIOD = 2.0, 0.01  # s, of a run and between samples


def main(environments: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Closes on the box at random pressures; returns true and estimated joint angles of a finger, (E, T, N)."""
    scenario = sg.load_scenario("box_grasp", ["estimator.type=contact"])
    exported = sg.extras.export.to_mjcf(scenario)
    finger = sg.extras.export.sensed_fingers(scenario)["left_finger"]
    model = mujoco.MjModel.from_xml_string(exported.text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    begin = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, begin, mujoco.mjtState.mjSTATE_FULLPHYSICS)

    steps = round(SECONDS / model.opt.timestep)
    pressure = np.random.default_rng(0).uniform(50e3, 150e3, (environments, 1, model.nu))  # Pa, of both fingers
    threads = [mujoco.MjData(model) for _ in range(os.cpu_count() or 1)]
    control = np.broadcast_to(pressure, (environments, steps, model.nu))
    states, _ = rollout(model, threads, np.tile(begin, (environments, 1)), control)

    places = 1 + np.array([model.joint(joint).qposadr[0] for joint in finger.joints])  # time comes first in a state
    every = round(PERIOD / model.opt.timestep)
    q = states[:, every - 1 :: every, places]  # (E, T, N)
    in_chambers = 1 + model.nq + model.nv + model.actuator_actadr[model.actuator("left_finger").id]
    shape = finger.estimate(finger.read(q), states[:, every - 1 :: every, [in_chambers]])
    wrong = np.linalg.norm(shape.q[:, -1] - q[:, -1], axis=-1)
    force = shape.contact.force[:, -1]
    print(
        f"{environments} environments, {q.shape[1]} samples: joint angles within {np.degrees(wrong.max()):.2f} degrees"
    )
    print(f"estimated contact forces at the end: {force.min():.2f} to {force.max():.2f} N")
    return q, shape.q


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
