"""What this extra adds: an engine of scenarios."""

from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from soft_gripper.errors import InputError

if TYPE_CHECKING:  # scenarios are read without it
    from soft_gripper.scenario.schema import Scenario

ENGINES = {"mujoco": "soft_gripper.extras.mujoco_engine.adds:run_many"}


def run_many(scenarios: "Sequence[Scenario]", described: bool = True) -> Iterator[Any]:
    """Runs scenarios in MuJoCo, see `engine`.

    Raises:
        InputError: if MuJoCo is not installed, or too old to step many simulations.
    """
    if find_spec("mujoco") is None or find_spec("mujoco.batch") is None:
        expected = "needs MuJoCo 3.17 or newer: pip install 'soft-gripper[mujoco]'"
        raise InputError("scenario", "engine", "mujoco", expected)
    from soft_gripper.extras.mujoco_engine.engine import run_many as run

    return run(scenarios, described)
