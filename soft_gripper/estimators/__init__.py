"""The estimators of the shape, and the block that holds one."""
