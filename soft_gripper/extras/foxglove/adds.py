"""What this extra adds: a form of recordings."""

RECORDINGS = {".mcap": "soft_gripper.extras.foxglove.write_mcap:write_mcap"}
