"""An action, applied: numbers from -1 to 1 -> the set points of grip and arm."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.systems.framework import DiagramBuilder, InputPort
from pydrake.systems.primitives import AffineSystem
from scipy.linalg import expm

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.learning.schema.config import ActionConfig


def action_ranges(config: ActionConfig) -> Array:
    """What the numbers of an action set at -1 and at 1, (n, 2) Pa or m or rad."""
    return np.array([config.range, *config.joints.values()])


def resting_action(config: ActionConfig, home: Mapping[str, float]) -> Array:
    """The action with which an episode begins, (n): the grip's rest and the joints' home, by their names."""
    least, most = action_ranges(config).T
    begin = np.array([config.rest, *(home[name] for name in config.joints)])
    resting: Array = np.clip(2 * (begin - least) / (most - least) - 1, -1, 1)
    return resting


def add_action(
    builder: DiagramBuilder,
    config: ActionConfig,
    grips: Sequence[InputPort],
    desired: InputPort | None,
    home: Mapping[str, float],
    period: float,
) -> None:
    """Exports the input `action` (n), and adds `action.grip` and, with joints, `action.joints`.

    ::

        action (n) ---> action.grip ----> pressure of every finger, Pa, or opening, m
               +------> action.joints --> desired state of the arm, positions and velocities (2 m)

    Args:
        builder: of the diagram.
        config: what an action sets.
        grips: where the pressures or the opening go in.
        desired: where the desired state of the arm goes in, if there is one.
        home: positions in which the joints of the arm begin, by their names, in the order of the arm; those that no
            action moves stay there.
        period: of the samples at which joints are commanded, s.

    Raises:
        InputError: if a joint is none of the arm.
    """
    least, most = action_ranges(config).T
    gain = np.diag((most - least) / 2)
    grip = AffineSystem(D=gain[:1], y0=(least + most)[:1] / 2)
    builder.AddNamedSystem("action.grip", grip)
    builder.ExportInput(grip.get_input_port(), "action")
    for port in grips:
        builder.Connect(grip.get_output_port(), port)
    if desired is not None:
        rows = _joint_rows(config, list(home))
        middle = rows @ (least + most) / 2
        motion = _joint_motion(rows @ gain, middle, np.array([*home.values()]), config.settling, period)
        builder.AddNamedSystem("action.joints", motion)
        builder.ConnectInput("action", motion.get_input_port())
        builder.Connect(motion.get_output_port(), desired)


def _joint_rows(config: ActionConfig, joints: list[str]) -> Array:
    """Which number of an action moves which joint of the arm, (m, n)."""
    rows = np.zeros((len(joints), 1 + len(config.joints)))
    for i, name in enumerate(config.joints, 1):
        if name not in joints:
            raise InputError("action", "joints", name, f"the arm has: {', '.join(joints)}")
        rows[joints.index(name), i] = 1.0
    return rows


def _joint_motion(gain: Array, middle: Array, home: Array, time: float, period: float) -> AffineSystem:
    """Critically damped motion of each joint q to its set point r, of time constant T, exact at the samples:

    T^2 q'' = r - q - 2 T q'. It begins at rest at home. A joint that no action moves has its home as set point.

    Args:
        gain: from the action to the set points, (m, n).
        middle: set points at an action of 0, (m).
        home: (m).
        time: T, s.
        period: of the samples, s.
    """
    count = len(home)
    middle = np.where(gain.any(axis=1), middle, home)
    flow = np.array([[0.0, 1.0, 0.0], [-1 / time**2, -2 / time, 1 / time**2], [0.0, 0.0, 0.0]])
    step = np.kron(expm(flow * period)[:2], np.eye(count))
    A, to_set_point = step[:, : 2 * count], step[:, 2 * count :]
    begin = np.concatenate([home, np.zeros(count)])
    return AffineSystem(
        A=A, B=to_set_point @ gain, f0=to_set_point @ (middle - home), C=np.eye(2 * count), y0=begin, time_period=period
    )
