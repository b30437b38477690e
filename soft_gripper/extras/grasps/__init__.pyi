"""How well objects are grasped: trials of a task over random objects, and the strength of one grasp."""

from .strength import grasp_strength as grasp_strength
