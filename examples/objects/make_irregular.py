"""Makes irregular.obj: an uneven, non-convex body like a turnip, watertight, on a foot that is wider than its neck.

Its sides roughly follow the curve of a soft finger that closes on them, so that fingers wrap around it.
"""

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

PROFILE = [  # mm: height, mean distance of the surface from the axis
    (0, 13.5),
    (9, 11.3),
    (18.75, 10.6),
    (26.5, 16.8),
    (35, 22.5),
    (44.2, 26.9),
    (53.6, 30.2),
    (63.3, 32.4),
    (73, 33.5),
    (83, 33.8),
    (95, 32.6),
    (106, 27.5),
    (114, 13),
]


def radius(azimuth: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Distance of the surface from the axis, m, at a height in m."""
    heights, distances = np.array(PROFILE).T / 1e3
    along = height / heights[-1]
    bumps = 0.6 * np.sin(2 * azimuth + 0.8) + 0.5 * np.sin(3 * azimuth - 9 * along) + 0.3 * np.sin(5 * azimuth)
    return PchipInterpolator(heights, distances)(height) + 1e-3 * bumps * np.sin(np.pi * along)


def make_mesh(rings: int = 26, spokes: int = 28) -> trimesh.Trimesh:
    """Rings of vertices around the axis, closed by a vertex at the foot and one at the top."""
    top = PROFILE[-1][0] / 1e3
    azimuths = np.arange(spokes) * 2 * np.pi / spokes
    h, a = np.meshgrid(np.linspace(0, top, rings), azimuths, indexing="ij")
    r = radius(a, h)
    side = np.stack([r * np.cos(a), r * np.sin(a), h], axis=-1).reshape(-1, 3)
    vertices = np.vstack([side, [0, 0, 0], [0, 0, top * 1.01]])
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
    mesh.export("irregular.obj", header=None, digits=6)
    print(mesh.bounds, mesh.volume, mesh.convex_hull.volume, mesh.moment_inertia / mesh.volume)
