"""The health of fingers and sensors: faults named with a probability, and faulty sensors dropped."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
