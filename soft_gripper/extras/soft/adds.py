"""Additions of this extra to scenarios: soft objects, by fields of a mesh."""

from dataclasses import dataclass

from soft_gripper.quantity import quantity


@dataclass
class SoftMesh:
    """Properties of a soft object, whose file is a mesh of tetrahedra (.vtk)."""

    youngs_modulus: float | None = quantity(None, "Pa", above=0)  # None: it is rigid
    poissons_ratio: float = quantity(0.3, least=0, below=0.5)  # of a soft object
    relaxation_time: float = quantity(0.02, "s", least=0)  # of a soft object: damping over stiffness


FIELDS = {"MeshConfig": SoftMesh}
DEFORMABLES = {"soft": "soft_gripper.extras.soft.soft_kind:SoftKind"}
MESHES = {".vtk": "soft_gripper.extras.soft.soft_kind:read_surface"}
