"""The tasks in our second engine: whole runs of the scenario, many at once, as sweeps and trials make them."""

from collections.abc import Iterator
from copy import deepcopy
from itertools import product
from time import process_time
from typing import cast

import mujoco  # noqa: F401  or the engine is left out
import numpy as np

from soft_gripper.diagrams.simulation import Run as Simulated
from soft_gripper.diagrams.simulation import run_many
from studies.peers.task import PeerTask, PeerTrial, Run, Setting

_PLANE_AXES = np.array([1j, 0, 1])  # of a finger, as a complex number
_SENSED_SIGNALS = ("strain", "theta", "estimated_joint_angles", "external_torque")


def make_run(task: PeerTask, setting: Setting) -> Run:
    """Makes equal runs of the task, `runs` at once; a `time_step` of the setting refines the engine's step.

    The tips are those of the sample before, as all truth in a recording, also in the converged run.
    """
    scenario = deepcopy(task.scenario)
    scenario.engine = "mujoco"
    scenario.plant_config.time_step = setting.get("time_step", scenario.plant_config.time_step)
    scenarios = [scenario] * setting["runs"]

    def run() -> PeerTrial:
        start = process_time()
        recordings = [run.recording for run in cast(Iterator[Simulated], run_many(scenarios, described=False))]
        for recording, finger, name in product(recordings, task.fingers, _SENSED_SIGNALS) if task.sensed else ():
            recording[f"{finger.name}.{name}"].to_numpy()  # computes it
        seconds = (process_time() - start) / len(scenarios)
        recording = recordings[0]
        names = [f"{finger.name}.true_tip_position" for finger in task.fingers]
        tips = np.array([recording.samples(name) @ _PLANE_AXES for name in names]).T
        return PeerTrial(seconds, tips, task.object_positions(recording))

    run()  # its station is built
    return run
