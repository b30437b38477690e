"""The named signals of a station: which there are, their units and their axes."""

from typing import NamedTuple


class Signal(NamedTuple):
    """What a port carries; `axes` name the dimensions that its vector is folded into."""

    unit: str
    axes: tuple[str, ...] = ()


# What the entries along an axis are called; the others are counted from the base.
LABELS = {
    "xz": ["x", "z"],
    "xyz": ["x", "y", "z"],
    "wrench": ["torque_x", "torque_y", "torque_z", "force_x", "force_y", "force_z"],
    "pose": ["x", "z", "heading"],
    "arc": ["x", "z", "heading", "kappa", "length", "center_x", "center_z"],
}

# Of every finger, named {finger}.{signal}; frame B where not said otherwise.
FINGER_SIGNALS = {
    "pressure_command": Signal("Pa"),
    "pressure": Signal("Pa"),
    "sampled_joint_angles": Signal("rad", ("joint",)),
    "extension_ratio": Signal("1", ("path", "section")),
    "strain": Signal("1", ("path", "section")),
    "theta": Signal("rad", ("section",)),
    "kappa": Signal("1/m", ("section",)),
    "arcs": Signal("m, m, rad, 1/m, m, m, m", ("section", "arc")),
    "joint_positions": Signal("m", ("joint", "xz")),
    "joint_positions_world": Signal("m", ("joint", "xyz")),
    "tip_pose": Signal("m, m, rad", ("pose",)),
    "pose_error": Signal("m"),
    "fingertip_error": Signal("m"),
    "sampled_pressure": Signal("Pa"),
    "free_bending_angles": Signal("rad", ("joint",)),
    "external_torque": Signal("N m", ("joint",)),
    "true_external_torque": Signal("N m", ("joint",)),
    "external_torque_error": Signal("N m", ("joint",)),
}
# Of the closed loop, named grip.{signal}.
GRIP_SIGNALS = {"set_point": Signal("m"), "distance": Signal("m"), "torque": Signal("N m")}
# Where contact is looked for: of every finger, and of two of them, named grip.{signal}.
CONTACT_SIGNALS = {
    "contact": Signal("1"),
    "contact_residual": Signal("N m"),
    "contact_time": Signal("s"),
    "normal_force": Signal("N"),
    "contact_center": Signal("m", ("xyz",)),
}
WIDTH_SIGNALS = {"object_width": Signal("m"), "true_object_width": Signal("m"), "object_width_error": Signal("m")}
# Of a task, named task.{signal}.
TASK_SIGNALS = {
    "phase": Signal("1"),
    "outcome": Signal("1"),
    "desired_state": Signal("m, rad; m/s, rad/s", ("arm_state",)),
}
PLANT_STATE = Signal("m, rad; m/s, rad/s", ("state",))
# Of every free object, named {object}.contact_force: torque and force on it, in the world.
CONTACT_FORCE = Signal("N m, N", ("wrench",))
