"""Makes sphere.obj and cylinder.obj: a ball, and a low tin; watertight, their frames in the centres."""

import trimesh

RADIUS, HEIGHT = 0.023, 0.032  # m, the height of the cylinder
FACETS = 48  # of the cylinder


def make_meshes() -> dict[str, trimesh.Trimesh]:
    """The meshes by the names of their files."""
    return {
        "sphere": trimesh.creation.icosphere(subdivisions=3, radius=RADIUS),
        "cylinder": trimesh.creation.cylinder(RADIUS, HEIGHT, FACETS),
    }


if __name__ == "__main__":
    for name, mesh in make_meshes().items():
        assert mesh.is_watertight
        mesh.export(f"{name}.obj", header=None, digits=6)
        print(name, mesh.bounds, mesh.volume)
