"""The arm: kinematics, motions, and the phases of a task."""
