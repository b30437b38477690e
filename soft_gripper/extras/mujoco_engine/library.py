"""Loads MuJoCo safely: by itself it would run modules of the current folder, and write warnings to a file there."""

import logging

from soft_gripper.child_processes import SAFE_PATH, environment
from soft_gripper.errors import InputError

_LOGGER = logging.getLogger(__name__)


def load_mujoco() -> None:
    """Imports MuJoCo; call it before the first import of `mujoco`.

    Raises:
        InputError: if it is not installed, or too old.
    """
    try:
        with environment(SAFE_PATH):  # its import of glfw starts `python -c`
            import mujoco.batch
    except ImportError:
        expected = "needs MuJoCo 3.17: pip install 'soft-gripper[mujoco]'"
        raise InputError("scenario", "engine", "mujoco", expected) from None
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_log)  # otherwise, warnings are written to MUJOCO_LOG.TXT


def _log(message: str) -> None:
    """Logs a warning, except on divergence, which ends the run with an error."""
    if "simulation is unstable" not in message:
        _LOGGER.warning(message)
