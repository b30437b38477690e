"""Soft objects of scenarios: read from a mesh of tetrahedra, checked, and drawn."""

import logging
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from pydrake.geometry import Meshcat, SceneGraph, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.diagrams.wiring.named_wires import inputs
from soft_gripper.errors import InputError
from soft_gripper.extras.soft.adds import SoftMesh
from soft_gripper.extras.soft.soft_object import SoftBody
from soft_gripper.extras.soft.soft_visualizer import SoftVisualizer, drawn_bodies
from soft_gripper.extras.soft.tetrahedra import SUFFIX, Tetrahedra, read_tetrahedra
from soft_gripper.files.xml_text import DRAKE
from soft_gripper.model_import.forms.mesh import add_geometry, add_values, add_visual
from soft_gripper.scenario.deformables import Deformable, DeformableKind, deformable_body
from soft_gripper.scenario.schema import MeshConfig, Scenario

if TYPE_CHECKING:  # imported when a mesh is read
    import trimesh

_LOGGER = logging.getLogger(__name__)
_INWARD_FRACTION = 1e-6  # of the distance to the middle of an element


class SoftKind(DeformableKind):
    """Objects whose mesh has a modulus, and files of finite elements."""

    def is_meant(self, config: MeshConfig) -> bool:
        return cast(SoftMesh, config).youngs_modulus is not None

    def add_to_link(self, config: MeshConfig, link: ET.Element, path: Path, density: float, friction: float) -> None:
        """Adds finite elements, drawn as their surface."""
        soft_mesh = cast(SoftMesh, config)
        if path.suffix.lower() != SUFFIX:
            expected = (
                f"is for a mesh of tetrahedra, a {SUFFIX} file; meshers such as Gmsh and fTetWild make one of a surface"
            )
            raise InputError(path, "mesh.youngs_modulus", soft_mesh.youngs_modulus, expected)
        from soft_gripper.model_import.mesh_files import keep_by_content, obj_text

        elements = read_tetrahedra(path).scaled(config.scale)
        surface_text = obj_text(surface(_inset_mesh(elements)).smooth_shaded, normals=True)
        add_visual(link, f"file://{keep_by_content(surface_text)}", config.color)
        body = add_geometry(link, "collision", f"file://{keep_by_content(elements.as_vtk(), SUFFIX)}")
        add_values(ET.SubElement(body, DRAKE + "proximity_properties"), {"mu_dynamic": friction})
        material = {
            "youngs_modulus": soft_mesh.youngs_modulus,
            "poissons_ratio": soft_mesh.poissons_ratio,
            "stiffness_damping": soft_mesh.relaxation_time,
            "mass_density": density,
        }
        add_values(ET.SubElement(link, DRAKE + "deformable_properties"), material)

    def check_models(self, scenario: Scenario) -> None:
        if scenario.plant_config.time_step == 0 and any(self.is_meant(model.mesh) for model in scenario.models):
            raise InputError("plant_config", "time_step", 0, "must be above 0: soft objects are simulated in steps")

    def check_scene(self, scenario: Scenario) -> None:
        """Checks the bodies next to soft objects, since some would fall through them without an error.

        Raises:
            InputError: for a part of the scenario that does not go with them.
        """
        if scenario.points is not None:
            raise InputError("scenario", "contact", "points", "must be surface: soft objects touch surfaces only")
        for i, model in enumerate(scenario.models):
            if model.half_space:
                expected = "leave it out: soft objects fall through half spaces"
                raise InputError(f"models[{i}]", "half_space", True, expected)
        approximation = scenario.plant_config.discrete_contact_approximation
        if approximation != "sap":
            expected = "plant_config.discrete_contact_approximation: %s lets soft objects jitter at rest; sap does not"
            _LOGGER.warning(expected, approximation)

    def objects(
        self, plant: MultibodyPlant, inspector: SceneGraphInspector, names: Iterable[str]
    ) -> dict[str, SoftBody]:
        bodies = {}
        for name in names:
            if body := deformable_body(plant, plant.GetModelInstanceByName(name)):
                vertices = body.get_default_pose().inverse() @ body.GetPositions(plant.CreateDefaultContext())
                elements = inspector.GetReferenceMesh(body.geometry_id()).tetrahedra()
                cells = np.array([[element.vertex(i) for i in range(4)] for element in elements])
                bodies[name] = SoftBody(name, body, Tetrahedra(vertices.T, cells))
        return bodies

    def add_view(
        self,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        objects: Mapping[str, Deformable],
        signals: Mapping[str, OutputPort],
        meshcat: Meshcat,
        period: float,
    ) -> None:
        bodies = drawn_bodies(plant, scene_graph, cast(Mapping[str, SoftBody], objects))
        drawing = builder.AddNamedSystem("soft_visualizer", SoftVisualizer(meshcat, bodies, period))
        for name, port in inputs(drawing).items():
            builder.Connect(signals[name], port)


def read_surface(path: Path) -> "trimesh.Trimesh":
    """The surface of a mesh file of tetrahedra."""
    return surface(read_tetrahedra(path))


def surface(tetrahedra: Tetrahedra) -> "trimesh.Trimesh":
    """The surface of a mesh of tetrahedra."""
    import trimesh

    mesh = trimesh.Trimesh(tetrahedra.vertices, tetrahedra.boundary, process=False)
    mesh.remove_unreferenced_vertices()
    return mesh


def _inset_mesh(mesh: Tetrahedra) -> Tetrahedra:
    """Copies a mesh with each vertex moved slightly into one of its elements.

    Drake draws a point by the element in which it finds it, and may find none for a point on a face.
    """
    middles = mesh.vertices[mesh.cells].mean(axis=1)
    element_of = np.empty(len(mesh.vertices), dtype=int)
    element_of[mesh.cells] = np.arange(len(mesh.cells))[:, None]
    return Tetrahedra(mesh.vertices + _INWARD_FRACTION * (middles[element_of] - mesh.vertices), mesh.cells)
