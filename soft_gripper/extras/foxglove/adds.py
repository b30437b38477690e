"""Additions of this extra: a form of recordings."""

RECORDINGS = {".mcap": "soft_gripper.extras.foxglove.write_mcap:write_mcap"}
