"""Finds simulators by name. Another simulator is a line of `_MODULES`, and a module here with `make_run`."""

from collections.abc import Callable
from importlib import import_module

from studies.peers.task import PeerTask, Run, Setting

MakeRun = Callable[[PeerTask, Setting], Run]
OURS = "soft-gripper"
_MODULES = {
    OURS: "ours",
    "soft-gripper, engine mujoco": "engine_peer",
    "MuJoCo": "mujoco_peer",
    "PyBullet": "bullet_peer",
    "PyElastica": "elastica_peer",
}


def find_simulator(name: str) -> MakeRun:
    """Imports the function that makes the runs of a simulator.

    Raises:
        ModuleNotFoundError: if it is not installed.
    """
    make_run: MakeRun = import_module(f"studies.peers.{_MODULES[name]}").make_run
    return make_run
