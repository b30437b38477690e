"""Gymnasium environments of soft grippers; to import this registers SoftReach-v0, SoftGrasp-v0 and SoftPickPlace-v0."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
