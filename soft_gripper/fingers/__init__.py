"""What a finger is, and the chain of links, springs and pressures that stands for it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
