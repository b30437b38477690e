"""Evaluation of recordings: averages over steady states, tables, figures, and the claims of the paper."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
