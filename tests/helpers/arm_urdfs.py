"""What the tests of third-party arms share: pieces of URDF, and plants that pydrake alone loads from it."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from pydrake.geometry import MakeRenderEngineVtk, RenderEngineVtkParams
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from soft_gripper.files.notes import report
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.model_import.imported_model import ImportOptions
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import read_model

SIZE = np.array([0.1, 0.2, 0.3])  # m, of the box in every mesh file
INERTIAL = "<inertial><mass value='2'/><inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial>"
ZERO_INERTIAL = INERTIAL.replace("'2'", "'0'").replace("0.1", "0")
RED, GREEN = (204, 0, 0, 255), "<material name='green'><color rgba='0 0.8 0 1'/></material>"
LIMIT = "<limit lower='-2' upper='2' velocity='3' effort='40'/>"


def link(name, inside=INERTIAL):
    return f"<link name='{name}'>{inside}</link>"


def joint(name, parent, child, inside=LIMIT, kind="revolute"):
    ends = f"<origin xyz='0 0 0.4'/><parent link='{parent}'/><child link='{child}'/><axis xyz='0 1 0'/>"
    return f"<joint name='{name}' type='{kind}'>{ends}{inside}</joint>"


def shape(kind, mesh, inside=""):
    return f"<{kind}><geometry><mesh {mesh}/></geometry>{inside}</{kind}>"


ARM = link("base") + joint("shoulder", "base", "upper") + link("upper") + joint("elbow", "upper", "fore") + link("fore")


def write_urdf(folder: Path, inside: str) -> Path:
    """A URDF file `arm.urdf` of a robot named `acme`."""
    path = folder / "arm.urdf"
    path.write_text(f"<?xml version='1.0'?>\n<robot name='acme' xmlns:xacro='http://ros.org/xacro'>{inside}</robot>")
    return path


class Loaded:
    """What pydrake alone makes of URDF text: a discrete plant whose first link is welded to the world."""

    def __init__(self, text, render=False):
        builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
        if render:
            self.scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))
        (self.model,) = Parser(self.plant).AddModelsFromString(text, "urdf")
        self.base = self.plant.get_body(self.plant.GetBodyIndices(self.model)[0])
        self.plant.WeldFrames(self.plant.world_frame(), self.base.body_frame())
        self.actuators = [self.plant.get_joint_actuator(i) for i in self.plant.GetJointActuatorIndices()]
        for actuator in self.actuators:
            actuator.set_controller_gains(PdControllerGains(p=100.0, d=10.0))
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)

    def query(self):
        return self.scene_graph.get_query_output_port().Eval(self.scene_graph.GetMyContextFromRoot(self.root))

    def geometries(self, role):
        inspector = self.scene_graph.model_inspector()
        return [(inspector.GetShape(i), i) for i in inspector.GetAllGeometryIds(role)]

    def mass_matrix(self):
        return self.plant.CalcMassMatrix(self.context)

    def end_after(self, time):
        """Joint positions after the set points were held at zero for a time, s."""
        self.plant.get_desired_state_input_port(self.model).FixValue(self.context, np.zeros(2 * len(self.actuators)))
        Simulator(self.diagram, self.root).AdvanceTo(time)
        return self.plant.GetPositions(self.context)


def arm_urdf(path):
    """What Drake reads of a URDF file of an arm."""
    file = ModelFile(path, ET.fromstring(expand_urdf(path).text))
    text = read_model(file, ImportOptions(is_arm=True)).text
    report(file.notes)
    return text


def load(path, **options):
    return Loaded(arm_urdf(path), **options)


def box(path, color=None):
    """A mesh file of a box of SIZE, in the format that its name says."""
    mesh = trimesh.creation.box(SIZE)
    if color:
        mesh.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=color))
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh.export(path)
    return path
