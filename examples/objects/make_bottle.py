"""Makes bottle.obj: a small bottle with a straight body, shoulder and neck, watertight; its frame is at its foot."""

import numpy as np
import trimesh

RADIUS, NECK = 0.022, 0.009  # m
BODY, SHOULDER, HEIGHT = 0.075, 0.095, 0.12  # m, heights at which body, shoulder and neck end
EDGE = 0.003  # m, by which the edge of the foot is bevelled
SPOKES = 36


def profile() -> np.ndarray:
    """Distances from the axis and heights, m, from the foot to the mouth."""
    along = np.linspace(0, 1, 6)
    shoulder = NECK + (RADIUS - NECK) * (1 + np.cos(np.pi * along)) / 2
    foot = [(0, 0), (RADIUS - EDGE, 0), (RADIUS, EDGE)]
    rings = [*foot, *zip(shoulder, BODY + (SHOULDER - BODY) * along, strict=True), (NECK, HEIGHT), (0, HEIGHT)]
    return np.array(rings)


def make_mesh() -> trimesh.Trimesh:
    """Revolves the profile about the z axis."""
    return trimesh.creation.revolve(profile(), sections=SPOKES)


if __name__ == "__main__":
    mesh = make_mesh()
    assert mesh.is_watertight
    mesh.export("bottle.obj", header=None, digits=6)
    print(mesh.bounds, mesh.volume, mesh.center_mass)
