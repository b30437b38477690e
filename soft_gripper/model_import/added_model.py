"""A model once Drake has read it, whatever the form of its file."""

from collections.abc import Sequence
from dataclasses import dataclass

from pydrake.geometry import GeometryId, Role
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import Joint, ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.model_import.drake_parsing import add_file, add_text
from soft_gripper.model_import.imported_model import ImportedModel, Mimic
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.models import package_map

_TIME_STEP = 1e-3  # s, of a plant that only weighs


@dataclass(frozen=True)
class AddedModel:
    """A model in a plant that is not finalized."""

    file: ModelFile
    parser: Parser
    indices: Sequence[ModelInstanceIndex]  # of all models in the file
    mimics: Sequence[Mimic]
    earlier: frozenset[GeometryId]  # geometries of other models

    @property
    def plant(self) -> MultibodyPlant:
        return self.parser.plant()

    @property
    def index(self) -> ModelInstanceIndex:
        """The only model, or the first."""
        return self.indices[0]

    def joint(self, name: str) -> Joint:
        """A joint of the model."""
        return self.plant.GetJointByName(name, self.index)

    def geometries(self, role: Role | None = None) -> set[GeometryId]:
        """Geometries that the file has added, of one role if given."""
        return _geometries(self.parser, role) - self.earlier


def add_model(parser: Parser, file: ModelFile, imported: ImportedModel) -> AddedModel:
    """Adds a model that was read from a file to the plant of a parser.

    Raises:
        InputError: if its text would end the process.
    """
    earlier = frozenset(_geometries(parser))
    if imported.text is None:
        indices = add_file(parser, file.path)
    else:
        indices = add_text(parser, imported.text, file.path, imported.suffix)
    return AddedModel(file, parser, indices, imported.mimics, earlier)


def model_mass(file: ModelFile, text: str, suffix: str) -> float:
    """The mass of all rigid links of a model, kg; notes on its text are left to who adds it to a plant."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, _TIME_STEP)
    parser = Parser(plant)
    parser.package_map().AddMap(package_map())
    count = len(file.notes)
    models = add_text(parser, text, file.path, suffix)
    del file.notes[count:]
    return float(sum(plant.get_body(i).default_mass() for model in models for i in plant.GetBodyIndices(model)))


def _geometries(parser: Parser, role: Role | None = None) -> set[GeometryId]:
    scene_graph = parser.scene_graph()
    return set() if scene_graph is None else set(scene_graph.model_inspector().GetAllGeometryIds(role))
