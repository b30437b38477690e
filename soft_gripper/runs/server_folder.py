"""Moves the server of worker processes away from the current folder, whose `matplotlibrc` matplotlib would obey.

The server imports this first, then what its processes need. They return to the folder of their parent.
"""

import os

os.chdir("/")
