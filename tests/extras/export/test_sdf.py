"""Scenarios as SDFormat, read again by Drake."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from command_line import soft_gripper
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.export.folder import export_sdf
from soft_gripper.library_messages import without_messages
from soft_gripper.scenario.scenario_file import load_scenario


def read(folder):
    """The plant in a file."""
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    with without_messages(lambda message: "gravity" in message):  # which Drake does not read
        Parser(plant).AddModels(str(folder / "scenario.sdf"))
    plant.Finalize()
    return plant


def weights(plant):
    """Eigenvalues of the mass matrix as a run begins, whatever the order of the joints."""
    return np.sort(np.linalg.eigvalsh(plant.CalcMassMatrix(plant.CreateDefaultContext())))


@pytest.mark.parametrize("name", ["box_grasp", "bottle_grasp", "three_chambers"])
def test_drake_reads_the_masses_that_it_had(tmp_path, name):
    scenario = load_scenario(name)
    export_sdf(scenario, tmp_path)
    np.testing.assert_allclose(weights(read(tmp_path)), weights(make_station(scenario).plant), rtol=1e-6)


def test_springs_friction_and_free_bodies(tmp_path):
    scenario = load_scenario("box_grasp")
    found = export_sdf(scenario, tmp_path)
    finger = make_station(scenario).fingers[0].finger
    root = ET.fromstring(found.text)
    springs = [float(spring.text) for spring in root.iter("spring_stiffness")]
    assert springs[:12] == finger.stiffness.tolist()
    plant = read(tmp_path)
    box = plant.GetBodyByName("box__box")
    assert plant.GetDefaultFloatingBaseBodyPose(box).translation().tolist() == [0, 0, 0.03001]
    (friction,) = root.findall(".//model[@name='box__box']//mu")
    assert friction.text == "0.8"


@pytest.mark.slow
def test_a_body_without_mass_does_not_become_heavy(tmp_path):
    """SDFormat assumes 1 kg for a link without an inertia, such as the frame at the end of an arm."""
    scenario = load_scenario("pick_and_place_box")
    export_sdf(scenario, tmp_path)
    mass, expected = (p.CalcTotalMass(p.CreateDefaultContext()) for p in (read(tmp_path), make_station(scenario).plant))
    assert mass == pytest.approx(expected, abs=1e-6)


def test_the_command_names_what_is_left_out(tmp_path):
    done = soft_gripper("export", "three_chambers", "--to", "sdf", "--out", tmp_path)
    assert done.code == 0
    assert "not exported: finger: pressures, SDFormat has no drive" in done.out
    assert (tmp_path / "scenario.sdf").is_file()
