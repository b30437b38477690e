"""Many runs: their executor and tables, sweeps of a scenario, agreement of engines, and tuning of gains."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
