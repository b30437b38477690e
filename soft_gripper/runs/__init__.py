"""Many runs: the executor, sweeps and tuning, and the scores of one."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
