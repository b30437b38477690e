"""Pictures of recordings: renderings, the shape of a finger, videos. None requires a display."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
