"""What this extra adds: an engine of scenarios."""

ENGINES = {"mujoco": "soft_gripper.extras.mujoco.engine:run_many"}
