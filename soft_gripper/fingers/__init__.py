"""The finger: its parameters, and the chain of links, springs and pressures that models it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
