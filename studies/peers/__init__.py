"""The same fingers and tasks in other simulators.

Other simulators read the expanded URDF, and the bodies around the fingers are read from Drake's plant: one
description of a scene for every simulator. Their settings are data (`settings.yaml`), so a better one takes one line.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported: times are of one
