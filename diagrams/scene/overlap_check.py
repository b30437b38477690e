"""Nothing may begin inside something else: contact would throw it out."""

from pydrake.geometry import (
    ContactSurface,
    HydroelasticContactRepresentation,
    SceneGraph,
    SceneGraphInspector,
)
from pydrake.systems.framework import Diagram

from soft_gripper.errors import InputError

MAX_RELATIVE_DEPTH = 0.1  # of the depth at which a compliant body is pressed through to its middle
MAX_RIGID_DEPTH = 1e-3  # m, between bodies that are both rigid


def check_starts_apart(diagram: Diagram, scene_graph: SceneGraph) -> None:
    """Looks at the contacts of the initial state.

    Raises:
        InputError: if a body begins deeper in another one than a touch.
    """
    context = scene_graph.GetMyContextFromRoot(diagram.CreateDefaultContext())
    query = scene_graph.get_query_output_port().Eval(context)
    kind = HydroelasticContactRepresentation.kTriangle
    surfaces, point_pairs = query.ComputeContactSurfacesWithFallback(kind)
    inspector = query.inspector()
    deep = [(s.id_M(), s.id_N()) for s in surfaces if _depth(inspector, s) > MAX_RELATIVE_DEPTH]
    deep += [(pair.id_A, pair.id_B) for pair in point_pairs if pair.depth > MAX_RIGID_DEPTH]
    for pair in deep:
        one, other = (inspector.GetName(inspector.GetFrameId(id)) for id in pair)
        raise InputError(
            "models", "X_PC", one, f"begins inside '{other}'; move one of them away, or leave links out with `without`"
        )


def _depth(inspector: SceneGraphInspector, surface: ContactSurface) -> float:
    """How deep the bodies lie in each other, as a part of the softer one's half thickness."""
    moduli = [
        inspector.GetProximityProperties(id).GetPropertyOrDefault("hydroelastic", "hydroelastic_modulus", float("inf"))
        for id in (surface.id_M(), surface.id_N())
    ]
    pressure = surface.tri_e_MN()
    return max(pressure.EvaluateAtVertex(v) for v in range(surface.num_vertices())) / min(moduli)
