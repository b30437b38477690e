"""Makes irregular.obj: an uneven, non-convex body with a waist, watertight, with a flat foot to stand on."""

from pathlib import Path

import numpy as np
import trimesh

HEIGHT = 0.066  # m


def radius(azimuth: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Distance of the surface from the axis, m; `height` runs from 0 (foot) to 1 (top)."""
    waist = 0.0225 - 0.0065 * np.exp(-(((height - 0.45) / 0.2) ** 2))
    bumps = 0.0018 * np.sin(2 * azimuth + 0.8) + 0.0012 * np.sin(3 * azimuth - 5 * height)
    rounded = np.sqrt(np.clip(1 - ((height - 0.62) / 0.385) ** 4 * (height > 0.62), 0.02, 1))
    return (waist + bumps) * rounded


def make_mesh(rings: int = 15, spokes: int = 24) -> trimesh.Trimesh:
    """Rings of vertices around the axis, closed by a vertex at the foot and one at the top."""
    heights = np.linspace(0, 1, rings)
    azimuths = np.arange(spokes) * 2 * np.pi / spokes
    h, a = np.meshgrid(heights, azimuths, indexing="ij")
    r = radius(a, h)
    side = np.stack([r * np.cos(a), r * np.sin(a), HEIGHT * h], axis=-1).reshape(-1, 3)
    vertices = np.vstack([side, [0, 0, 0], [0, 0, HEIGHT * 1.01]])
    here = np.arange(spokes)
    on = (here + 1) % spokes
    faces = [np.stack([on, here, np.full(spokes, len(side))], -1)]
    for ring in range(rings - 1):
        low, high = ring * spokes, (ring + 1) * spokes
        faces += [
            np.stack([low + here, low + on, high + on], -1),
            np.stack([low + here, high + on, high + here], -1),
        ]
    faces.append(np.stack([high + here, high + on, np.full(spokes, len(side) + 1)], -1))
    mesh = trimesh.Trimesh(vertices, np.vstack(faces))
    mesh.apply_translation(-mesh.center_mass)
    return mesh


if __name__ == "__main__":
    mesh = make_mesh()
    assert mesh.is_watertight
    mesh.export(Path(__file__).with_name("irregular.obj"), header=None, digits=6)
    print(mesh.bounds, mesh.volume, mesh.convex_hull.volume, mesh.moment_inertia / mesh.volume)
