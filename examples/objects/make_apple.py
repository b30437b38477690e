"""Makes apple.obj: an apple with its stem in a dimple, watertight, standing on a ring around another dimple."""

import numpy as np
import trimesh

RADIUS, HEIGHT = 0.03, 0.057  # m, the height without dimples and stem
STEM_DIMPLE, FOOT_DIMPLE = (0.0125, 0.0065), (0.006, 0.008)  # m, depth and radius
STEM = [(0.0016, 0.0), (0.0011, 0.008), (0.0011, 0.0155), (0.0, 0.0155)]  # m, radius at heights above its root


def profile(rings: int) -> np.ndarray:
    """Distances from the axis and heights, m, from the foot to the top of the stem; the rings are on the skin."""
    angle = np.linspace(0, np.pi, 2000)
    r = RADIUS * np.sin(angle - 0.22 * np.sin(angle)) ** 0.9  # widest above the middle
    foot, top = (depth * np.exp(-((r / radius) ** 1.6)) for depth, radius in (FOOT_DIMPLE, STEM_DIMPLE))
    z = np.where(angle < np.pi / 2, foot, -top) - HEIGHT / 2 * np.cos(angle)
    skin = np.stack([r, z], -1)[(angle < np.pi / 2) | (r > STEM[0][0])]
    along = np.cumsum(np.linalg.norm(np.diff(skin, axis=0, prepend=skin[:1]), axis=1))
    lengths = np.linspace(0, along[-1], rings)
    even = np.stack([np.interp(lengths, along, column) for column in skin.T], -1)
    return np.vstack([even, STEM[1:] + even[-1] * [0, 1]])


def make_mesh(rings: int = 21, spokes: int = 30) -> trimesh.Trimesh:
    """Revolves the profile and adds five lobes that grow toward the foot; the frame lies in the centre of mass."""
    mesh = trimesh.creation.revolve(profile(rings), sections=spokes)
    x, y, z = mesh.vertices.T
    lobes = 0.06 * np.clip(0.3 - z / HEIGHT, 0, None) * np.cos(5 * np.arctan2(y, x))
    mesh.vertices[:, :2] *= 1 + lobes[:, None]
    mesh.apply_translation(-mesh.center_mass)
    return mesh


if __name__ == "__main__":
    mesh = make_mesh()
    assert mesh.is_watertight
    mesh.export("apple.obj", header=None, digits=6)
    print(mesh.bounds, mesh.volume)
