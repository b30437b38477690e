"""Attributes of a recording that describe its run: scenario, blocks, versions, frames and notes."""

from collections.abc import Iterable
from functools import cache
from importlib.metadata import version

from soft_gripper.files.notes import Note, as_text
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import Scenario

FRAMES = (
    "SI units. W: the world. B: base of a finger, +z along the straight finger, +x toward the object; positive joint"
    " angles close it. joint_positions and tip_pose are in B, of an estimate in space as seen in the bending plane;"
    " estimated_joint_positions and estimated_tip_position are in B, joint_positions_world, contact_center and the"
    " rows of X_WB in W. A {object}.pose is its first link in W, a quaternion w x y z and a position; a contact_wrench"
    " acts on it about its origin, in W. An external torque is positive if it closes the finger and belongs to two"
    " samples before, or to the current sample if the estimator itself gives it (constant_curvature);"
    " external_torque_error is the difference from the true torque two samples before. true_external_torque belongs to"
    " the current sample. A true_contact_force acts across the finger, positive on the inner side, and the transverse"
    " force at right angles to the line from the base to the contact;"
    " true_contact_arc_length is its location, from the base, and true_contact_side the direction from which it"
    " presses, around the finger: 0 on the inner side, pi/2 on the side toward +y. true_contact_force_world is the sum"
    " of all contact forces on the finger, friction included, in W. true_sideways_torque and true_twist_torque are"
    " external torques about x and z at the joints."
)


_POINTS_NOTE = (
    "points on either side of every link of a finger; held objects creep faster than under contact over the surface,"
    " the faster, the fewer points: in the box grasp 0.08 mm/s with 4 points, 0.03 mm/s over the surface"
)


@cache
def _versions() -> str:
    return ", ".join(f"{name} {version(name)}" for name in ("soft-gripper", "drake", "numpy"))


def provenance(scenario: Scenario, sensor: str, estimator: str, notes: Iterable[Note] = ()) -> dict[str, str]:
    """Attributes of a recording: description, scenario as YAML, versions, frames, and notes on files, if there are any.

    `sensor` and `estimator` name the blocks, which may be user blocks instead of the scenario's.
    """
    return {
        "description": scenario.description,
        "contact": "surface" if scenario.contact == "surface" else f"{scenario.contact_points} {_POINTS_NOTE}",
        "scenario": dump_scenario(scenario),
        "sensor": sensor,
        "estimator": estimator,
        "versions": _versions(),
        "frames": FRAMES,
        **({"notes": note_text} if (note_text := as_text(notes)) else {}),
    }
