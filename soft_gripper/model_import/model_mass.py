"""The mass of a model, as Drake reads it."""

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.model_import.drake_parsing import add_text
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.models import package_map

_TIME_STEP = 1e-3  # s, of a plant that only weighs


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
