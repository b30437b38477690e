"""The attributes of a recording: its scenario, the versions that ran it, and the frames of its signals."""

from importlib.metadata import version

from soft_gripper.scenario.scenario import Scenario
from soft_gripper.scenario.scenario_file import dump_scenario

FRAMES = (
    "SI units. W: the world. B: base of a finger, +z along the straight finger, +x toward the object; positive joint"
    " angles close it. joint_positions and tip_pose are in B, joint_positions_world, contact_center and the rows of"
    " X_WB in W. A {object}.pose is its first link in W, a quaternion w x y z and a position; a contact_wrench acts on"
    " it about its origin, in W. An external torque is positive where it closes the finger and belongs to two samples"
    " before; true_external_torque to the sample. A true_contact_force acts across the finger, positive on the inner"
    " side; true_contact_arc_length is its place from the base."
)


def provenance(scenario: Scenario, sensor: str, estimator: str) -> dict[str, str]:
    """Attributes of a recording: description, scenario as YAML, versions, frames.

    `sensor` and `estimator` name the blocks, which a user may have given instead of the scenario's.
    """
    versions = (f"{name} {version(name)}" for name in ("soft-gripper", "drake", "numpy"))
    return {
        "description": scenario.description,
        "scenario": dump_scenario(scenario),
        "sensor": sensor,
        "estimator": estimator,
        "versions": ", ".join(versions),
        "frames": FRAMES,
    }
