"""The addition of this extra: an engine of scenarios."""

ENGINES = {"mujoco": "soft_gripper.extras.mujoco_engine.engine:run_many"}
ENGINE_STEPS = {"mujoco": "soft_gripper.extras.mujoco_engine.engine:suited_step"}
