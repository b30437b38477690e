"""An arm that carries a gripper, and the tasks that they do together."""
