"""Soft objects: bodies of finite elements that are grasped, and what is known of them in simulation."""
