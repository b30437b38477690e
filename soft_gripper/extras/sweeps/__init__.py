"""Many runs of a scenario: sweeps of its fields, agreement between engines, and tuning of gains."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
