"""Soft, sensing grippers on Drake's systems framework: the public names, each loaded when it is first used.

from soft_gripper import load_scenario, simulate

recording = simulate(load_scenario("box_grasp"))
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
