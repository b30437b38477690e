"""Interface of objects of finite elements: Drake has their bodies; an extra knows their files and ground truth.

An extra adds them by the name of a subclass of `DeformableKind`, as `DEFORMABLES = {name: "module:Class"}` in its
`adds`, and what reads the surface of their mesh files as `MESHES`.
"""

import xml.etree.ElementTree as ET
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from pydrake.geometry import GeometryId, Meshcat, SceneGraph, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import DeformableBody, ModelInstanceIndex
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from soft_gripper.arrays import Array
from soft_gripper.registry import registered
from soft_gripper.scenario.schema import MeshConfig, Scenario

if TYPE_CHECKING:  # imported when a signal is read
    import xarray as xr


class Deformable(ABC):
    """An object of finite elements in a finalized plant."""

    @property
    @abstractmethod
    def geometry(self) -> GeometryId:
        """Geometry that touches, and is drawn."""

    @property
    @abstractmethod
    def mass(self) -> float:
        """Mass of the object, kg."""

    @abstractmethod
    def vertices(self, context: Context) -> Array:
        """Vertices of its elements, in the context of the plant, (V, 3) m in the world."""

    @abstractmethod
    def restore(self, context: Context, signals: "xr.Dataset") -> None:
        """Gives it, in the context of the plant, the shape that one sample of a recording has."""

    @abstractmethod
    def check(self, context: Context) -> None:
        """Raises a SimulationDivergedError if its shape in the context of the plant is impossible."""

    @abstractmethod
    def add_signals(self, builder: DiagramBuilder, plant: MultibodyPlant) -> dict[str, OutputPort]:
        """Adds its ground truth to a diagram; returns its signals, `{object}.pose` and `{object}.contact_wrench` first.

        They may have `{object}.squeeze`, m, which a task can limit.
        """


class DeformableKind(ABC):
    """Reading, checking and drawing of objects of finite elements."""

    @abstractmethod
    def is_meant(self, config: MeshConfig) -> bool:
        """Whether the mesh of a model is to be an object of finite elements."""

    @abstractmethod
    def add_to_link(self, config: MeshConfig, link: ET.Element, path: Path, density: float, friction: float) -> None:
        """Describes an object of a density, kg/m^3, as the link of an SDFormat file."""

    @abstractmethod
    def check_models(self, scenario: Scenario) -> None:
        """Checks, before models are read, that a plant can have those of them that are of this kind."""

    @abstractmethod
    def check_scene(self, scenario: Scenario) -> None:
        """Checks the rest of a scenario that has one."""

    @abstractmethod
    def objects(
        self, plant: MultibodyPlant, inspector: SceneGraphInspector, names: Iterable[str]
    ) -> Mapping[str, Deformable]:
        """The objects of a finalized plant among the models with these names."""

    @abstractmethod
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
        """Adds a visualizer of objects; period, s."""


@cache
def deformable_kind() -> DeformableKind | None:
    """The kind that an extra adds; None if there is none."""
    return next((make() for make in registered("DEFORMABLES").values()), None)


def is_deformable(config: MeshConfig) -> bool:
    """Whether the mesh of a model is of finite elements."""
    kind = deformable_kind()
    return kind is not None and kind.is_meant(config)


def deformable_body(plant: MultibodyPlant, model: ModelInstanceIndex) -> DeformableBody | None:
    """The body of finite elements of a model instance, if it is one."""
    bodies = plant.deformable_model().GetBodyIds(model)
    return plant.deformable_model().GetBody(bodies[0]) if bodies else None
