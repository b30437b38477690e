"""Soft objects: grasped bodies of finite elements, and their ground truth."""
