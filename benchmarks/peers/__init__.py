"""The same fingers and tasks in other simulators.

Other simulators read the expanded URDF, and the bodies around the fingers are read from Drake's plant: one
description of a scene for every simulator. Their settings are data (`settings.yaml`), so a better one takes one line.
"""
