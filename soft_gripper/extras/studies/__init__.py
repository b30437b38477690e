"""Studies of sensing and grasping beyond the evaluation of the paper."""
