"""The search for the best design of a gripper, over any fields of its scenario."""
