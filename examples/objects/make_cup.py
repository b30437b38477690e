"""Makes cup.obj: a slender cone frustum like an upturned paper cup, closed, standing on its wider end."""

import trimesh

HEIGHT, FOOT, TOP = 0.065, 0.023, 0.020  # m: height, radius of the foot and of the top


def make_mesh() -> trimesh.Trimesh:
    """Revolves a trapezium about the z axis; the frame lies in the centre of mass."""
    mesh = trimesh.creation.revolve([[0, 0], [FOOT, 0], [TOP, HEIGHT], [0, HEIGHT]], sections=32)
    mesh.apply_translation(-mesh.center_mass)
    return mesh


if __name__ == "__main__":
    mesh = make_mesh()
    assert mesh.is_watertight
    mesh.export("cup.obj", header=None, digits=6)
    print(mesh.bounds, mesh.volume)
