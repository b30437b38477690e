"""Quality of grasps: trials of a task over random objects, and the strength of one grasp."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
