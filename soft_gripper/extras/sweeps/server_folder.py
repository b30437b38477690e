"""Moves the server of worker processes away from the current folder, whose `matplotlibrc` matplotlib would obey.

The server imports this first, then what its processes need. They return to the folder of their parent.
"""

import os
import sys
from multiprocessing import forkserver

if getattr(sys.modules["__main__"], "main", None) is forkserver.main:  # the server runs it
    os.chdir("/")
