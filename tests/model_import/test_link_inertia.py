"""Inertias of links, compared with Drake's own test of what a body can have, and with all nearer candidates."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import RotationalInertia
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.errors import InputError
from soft_gripper.model_import.links_and_joints import possible_inertia, repair_inertia
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import read_model
from soft_gripper.scenario.schema import ModelConfig

FILE = Path("arm.urdf")
RNG = np.random.default_rng(1)
SOLID = "<inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def second_moments(inertia):
    return np.trace(inertia) / 2 * np.eye(3) - inertia


def inertia_of_points(points):
    """Rotational inertia of particles of 1 kg, (3, 3) kg m^2."""
    return np.sum([(p @ p) * np.eye(3) - np.outer(p, p) for p in points], axis=0)


def is_possible(inertia):
    moments = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    try:
        return RotationalInertia(*moments).CouldBePhysicallyValid()
    except RuntimeError:
        return False


def symmetric():
    matrix = RNG.normal(size=(3, 3))
    return matrix + matrix.T


def test_what_a_body_can_have_stays():
    for _ in range(20):
        inertia = inertia_of_points(RNG.normal(size=(4, 3)))
        assert possible_inertia(4.0, inertia) is inertia


def test_it_becomes_the_nearest_that_is_possible():
    """Of 300 possible ones around it none has second moments that are nearer to those of the file."""
    inertia = np.array([[1.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 3.0]])
    assert not is_possible(inertia)
    nearest = possible_inertia(1e-9, inertia)
    distance = np.linalg.norm(second_moments(nearest - inertia))
    for _ in range(300):
        other = inertia_of_points(RNG.normal(size=(3, 3)) * 0.05) + nearest
        candidates = [other, nearest + 1e-2 * symmetric(), nearest * RNG.uniform(0.9, 1.1)]
        for candidate in filter(is_possible, candidates):
            assert np.linalg.norm(second_moments(candidate - inertia)) >= distance - 1e-9


@pytest.mark.parametrize("inertia", [np.zeros((3, 3)), np.diag([1.0, 1.0, 0.0])], ids=["point", "rod"])
def test_no_principal_moment_is_zero(inertia):
    possible = possible_inertia(3.0, inertia)
    assert is_possible(possible)
    assert np.linalg.eigvalsh(possible)[0] == pytest.approx(3.0 * 2e-6, rel=1e-6)  # 1 mm along two axes


def links(text, jointed=()):
    robot = ET.fromstring(f"<robot name='r'>{text}</robot>")
    repair_inertia(ModelFile(FILE, robot), jointed)
    return robot


def inertia_of(robot):
    inertial = robot.find("link/inertial")
    xx, yy, zz, xy, xz, yz = (float(inertial.find("inertia").get(key)) for key in MOMENTS)
    return float(inertial.find("mass").get("value")), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize("inertial", ["", "<inertial/>", SOLID.replace("'2'", "'0'")])
def test_a_link_without_mass(inertial):
    """With a joint of its own it becomes lighter than anything that matters; otherwise it adds no mass."""
    link = f"<link name='a'>{inertial}</link>"
    mass, inertia = inertia_of(links(link, {"a"}))
    assert 0 < mass <= 1e-3
    assert is_possible(inertia)
    assert 0 < np.linalg.eigvalsh(inertia)[0] <= np.linalg.eigvalsh(inertia)[2] < 1e-6
    assert links(link, {"b"}).find("link/inertial") is None


def test_a_link_that_is_wrong_keeps_its_centre_of_mass():
    origin = "<origin xyz='1 2 3' rpy='0.1 0.2 0.3'/>"
    text = SOLID.replace("izz='1'", "izz='5'").replace("<mass", f"{origin}<mass")
    robot = links(f"<link name='a'>{text}</link>")
    mass, inertia = inertia_of(robot)
    assert mass == 2
    assert is_possible(inertia)
    assert ET.tostring(robot.find("link/inertial/origin")) == ET.tostring(ET.fromstring(origin))


@pytest.mark.parametrize("jointed", ["a", "b"])
def test_a_mass_below_zero_is_refused(jointed):
    """On a joint or fixed to another link, where it would vanish."""
    with pytest.raises(InputError, match=r"arm\.urdf: link 'a': mass = -1\.0: give a mass of at least 0, kg"):
        links("<link name='a'>" + SOLID.replace("'2'", "'-1'") + "</link>", {jointed})


def test_a_centre_of_mass_that_overflows(tmp_path):
    (tmp_path / "far.xml").write_text(
        """<mujoco model="far"><worldbody><body name="base"><geom size="0.1"/><body name="far" pos="0 0 1">
        <joint/><inertial pos="0 1e308 0" mass="1" diaginertia="1 1 1"/><geom size="0.1"/></body></body></worldbody>
        </mujoco>"""
    )
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    with pytest.raises(InputError, match="link 'far': centre of mass"):
        load_model(plant, ModelConfig(name="far", file=str(tmp_path / "far.xml")), "models[0]")


def test_a_mass_below_zero_in_mjcf(tmp_path):
    (tmp_path / "arm.xml").write_text(
        '<mujoco><worldbody><body name="far"><inertial pos="0 0 0" mass="-2" diaginertia="1 1 1"/>'
        '<geom size="0.1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(InputError, match=r"mass = -2\.0: give a mass of at least 0, kg"):
        read_model(ModelFile(tmp_path / "arm.xml"))
