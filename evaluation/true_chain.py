"""Where a recorded finger truly lay."""

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.fingers.kinematics import Chain, forward_kinematics
from soft_gripper.fingers.plant_finger import PlantFinger


def true_chain(recording: Recording, finger: PlantFinger) -> Chain:
    """The chain in B at every sample, with axes (T, ...), by its joint angles and, if it does, its shear."""
    q = recording[f"{finger.name}.sampled_joint_angles"].values
    shear = recording[f"{finger.name}.sampled_shear"].values if finger.finger.shear_factor > 0 else None
    return forward_kinematics(q, finger.finger.segment_length, shear)
