"""The same fingers and tasks in other simulators.

Other simulators read the expanded URDF, and what stands around the fingers is read from Drake's plant: one
description of a scene for every simulator. Their settings are data (`settings.yaml`), so that a better one is a line.
"""
