"""The shake test against closed forms: the friction cone of two opposed pads, and the capstan of a wrapped cylinder."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from here_executor import HereExecutor
from pydrake.math import RigidTransform, RotationMatrix
from refusals import refused

from soft_gripper.extras.grasps import strength as module
from soft_gripper.extras.grasps.strength import (
    LOADS,
    Load,
    LoadSample,
    SettledGrasp,
    Shake,
    StrengthRow,
    _HeldBody,
    _row,
    held_object,
    shortened_scenario,
    strength_figure,
)
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario, parse_scenario

BAR = 0.05  # of the closed forms
GUARD = '<frame name="fingers: load with soft_gripper.add_fingers, or soft-gripper expand"/>'
INERTIAL = '<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'

PAD_FRICTION, PRESSURE, RADIUS = 0.5, 100e3, 0.0346  # m; the pad fills the space between the fingers
PAD_HEIGHT, BASE_HEIGHT = 0.04, 0.147  # m
PAD_MODULUS = 5.2e4  # Pa, of skin over the length of a finger, so that the pads are soft
PADS = """
models:
- name: gripper
  file: {folder}/gripper.urdf
  X_PC: {{ translation: [0, 0, 0.177], rotation: !Rpy {{ deg: [180, 0, 0] }} }}
  segments: 1
  fingers: {{ all: {{ contact.friction: {friction} }} }}
- name: pad
  file: {folder}/pad.obj
  free: true
  X_PC: {{ translation: [0, 0, {height}] }}
  mass: 0.02
  friction: {friction}
gravity: [0, 0, 0]
sensor: {{ sections: 1 }}
pressure: {{ steps: {{ all: [{pressure}] }}, settle: 1.0, time_constant: 0.3 }}
plant_config: {{ time_step: 0.005, stiction_tolerance: 1.0e-5 }}
"""


@pytest.fixture(scope="module")
def pads(tmp_path_factory: pytest.TempPathFactory) -> SettledGrasp:
    """Two fingers with one hinge each hold a cylinder that lies across them, and that weighs nothing."""
    folder = tmp_path_factory.mktemp("pads")
    mesh = trimesh.creation.cylinder(RADIUS, 0.03, sections=64)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    mesh.export(folder / "pad.obj")
    gripper = (DIRECTORY / "grippers" / "two_finger.urdf").read_text(encoding="utf-8")
    soft = gripper.replace("</finger>", f'<contact hydroelastic_modulus="{PAD_MODULUS}"/></finger>')
    (folder / "gripper.urdf").write_text(soft, encoding="utf-8")
    text = PADS.format(folder=folder, friction=PAD_FRICTION, pressure=PRESSURE, height=PAD_HEIGHT)
    return SettledGrasp.from_scenario(parse_scenario(folder / "pads.yaml", text), "pad")


def pad_force(settled: SettledGrasp) -> float:
    """Normal force of a finger, N: the torque of the pressure, less that of its spring, over the lever of the pad."""
    plant, finger = settled.station.plant, settled.station.fingers[0]
    context = plant.GetMyContextFromRoot(settled.context)
    angle = float(finger.joints[0].get_angle(context))
    lever = BASE_HEIGHT - PAD_HEIGHT - float(finger.finger.joint_arc_lengths[0])
    return float(finger.finger.pressure_gain[0] * PRESSURE - finger.finger.stiffness[0] * angle) / lever


@pytest.mark.slow
@pytest.mark.parametrize("load", [load for load in LOADS if not load.is_torque and load.axis > 0], ids=str)
def test_two_opposed_pads_hold_what_the_friction_cone_allows(pads, load):
    found = pads.strength(load, Shake())
    assert found.ended == "slid"
    assert found.strength == pytest.approx(2 * PAD_FRICTION * pad_force(pads), rel=BAR)


@pytest.mark.slow
def test_the_strength_does_not_depend_on_how_fast_the_load_grows(pads):
    fast, slow = (pads.strength(Load(False, 1, 1), Shake(seconds=seconds)).strength for seconds in (1.0, 4.0))
    assert fast == pytest.approx(slow, rel=0.01)


BELT_FRICTION, DRUM, HALF, TIP = 0.3, 0.03, 0.002, 0.1  # m, radius and half of the thickness; kg
BELT = f"""<robot name="belt"><link name="mount">{INERTIAL}</link>{GUARD}
<finger name="belt"><parent link="mount"/><body length="0.1" segments="20" relaxation_time="3"/>
<base width="0.02" thickness="{2 * HALF}" youngs_modulus="2e4" density="100"/>
<tip width="0.02" thickness="{2 * HALF}" youngs_modulus="2e4" density="100"/>
<sensors spacing="0.003"/><tip_load mass="{TIP}" xyz="0 0 0"/><contact friction="{BELT_FRICTION}"/></finger></robot>"""
AXLE = f"""<robot name="drum" xmlns:drake="http://drake.mit.edu"><link name="drum">{INERTIAL}
<collision><origin rpy="1.570796326794897 0 0"/><geometry><cylinder radius="{DRUM}" length="0.04"/></geometry>
<drake:proximity_properties><drake:rigid_hydroelastic/><drake:mesh_resolution_hint value="0.002"/>
<drake:hunt_crossley_dissipation value="2"/><drake:mu_static value="{BELT_FRICTION}"/>
<drake:mu_dynamic value="{BELT_FRICTION}"/></drake:proximity_properties></collision></link>
<link name="axle">{INERTIAL}</link>
<joint name="axis" type="continuous"><parent link="axle"/><child link="drum"/><axis xyz="0 1 0"/></joint></robot>"""
OVER_DRUM = """
models:
- name: belt
  file: {folder}/belt.urdf
  X_PC: {{ translation: [-0.01, 0, {height}], rotation: !Rpy {{ deg: [0, 90, 0] }} }}
- name: drum
  file: {folder}/drum.urdf
  child: axle
sensor: {{ sections: 1 }}
pressure: {{ settle: 1.0 }}
plant_config: {{ time_step: 0.005, stiction_tolerance: 1.0e-5 }}
"""


@pytest.mark.slow
def test_a_wrapped_cylinder_is_held_as_by_a_capstan(tmp_path: Path):
    """A thin finger with a weight at its tip hangs over a quarter of a drum, which is turned either way.

    Its axis runs at the radius r + h, friction acts at r, so that the tensions at both ends differ by the factor
    exp(mu phi r / (r + h)), and the torque is their difference times r + h.
    """
    (tmp_path / "belt.urdf").write_text(BELT)
    (tmp_path / "drum.urdf").write_text(AXLE)
    text = OVER_DRUM.format(folder=tmp_path, height=DRUM + HALF)
    settled = SettledGrasp.from_scenario(parse_scenario(tmp_path / "over_drum.yaml", text), "drum")
    grown = np.exp(BELT_FRICTION * np.pi / 2 * DRUM / (DRUM + HALF))
    weight = 1e3 * 9.81 * TIP * (DRUM + HALF)  # mN m
    shake = Shake(slid=0.01, turned=3.0)
    for sign, expected in ((1, weight * (grown - 1)), (-1, weight * (1 - 1 / grown))):
        found = settled.strength(Load(True, 1, sign), shake)
        assert (found.ended, found.unit) == ("slid", "mN m")
        assert found.strength == pytest.approx(expected, rel=BAR)


def test_a_task_is_run_until_it_holds_its_object():
    task = shortened_scenario(load_scenario("pick_and_place_box")).task
    assert [phase.name for phase in task.phases] == ["approach", "descend", "close", "lift"]
    assert len(shortened_scenario(load_scenario("bottle_grasp")).task.phases) == 2


def test_the_object_is_that_of_the_task_or_the_first_free_one():
    assert held_object(load_scenario("pick_and_place_box"), None) == "box"
    assert held_object(load_scenario("bottle_grasp"), None) == "bottle"
    assert held_object(load_scenario("bottle_grasp"), "table") == "table"
    with refused("--object", "cup"):
        held_object(load_scenario("bottle_grasp"), "cup")
    with refused("free models"):
        held_object(load_scenario("free_bending"), None)


def made_up(text: str, held: str, number: int, shake: Shake) -> StrengthRow:
    load = LOADS[number]
    kind, unit = ("torque", "mN m") if load.is_torque else ("force", "N")
    return StrengthRow(kind, load.name, 1.0 + number, unit, "slid" if number else "not lost", 1.0, 1.0, 1.0)


def test_twelve_loads_in_order_and_their_figure(monkeypatch):
    monkeypatch.setattr(module, "direction_strength", made_up)
    reported: list[int] = []
    rows = module.grasp_strength(load_scenario("bottle_grasp"), HereExecutor(), report=lambda: reported.append(1))
    assert [row.direction for row in rows] == ["+x", "-x", "+y", "-y", "+z", "-z"] * 2
    assert [row.strength for row in rows] == list(range(1, 13))
    assert len(reported) == 12
    forces, torques = strength_figure(rows, "title").axes
    assert (forces.get_xlabel(), torques.get_xlabel()) == ("force [N]", "torque [mN m]")
    assert [bar.get_width() for bar in forces.patches] == [1, -2, 3, -4, 5, -6]
    assert [text.get_text() for text in forces.texts] == ["> 1", "2", "3", "4", "5", "6"]


def pulled(moved, lost="slid"):
    """Samples of a load that grows to 10 N, which is resisted; `moved` is in m by its share of the largest."""
    shares = np.arange(1, 2001) / 2000
    return [LoadSample(10 * share, float(moved(share)), 0.1 * share, lost if share == 1 else "") for share in shares]


def test_the_stiffness_is_that_of_the_first_half_of_the_load():
    """A spring of 2 N/mm that gives way beyond: its motion doubles until the object slides."""
    row = _row("force", "+x", "N", pulled(lambda share: 5e-3 * share + 20e-3 * max(share - 0.5, 0.0)))
    assert row.stiffness == pytest.approx(2.0, rel=0.01)
    assert row.strength == pytest.approx(10, rel=0.01)
    assert (row.moved_mm, row.turned_deg) == pytest.approx((15, np.degrees(0.1)), rel=0.01)
    assert row.ended == "slid"


@pytest.mark.parametrize(
    ("turns", "slips", "ended"),
    [((10, 30), (0, 0), ""), ((25, 30), (0, 0), "turned"), ((0, 0), (4, 7), "slid"), ((0, 0), (2, 7), "")],
)
def test_an_object_is_lost_once_it_has_turned_in_every_finger_or_slid_on_average(monkeypatch, turns, slips, ended):
    """Degrees and mm; a finger that the object rolls over does not let go of it while another holds it."""
    monkeypatch.setattr(module, "shift", lambda context, grip, pose: 1e-3 * np.array([grip.slipped, 0, 0]))
    grips = [SimpleNamespace(link=turned, slipped=slipped) for turned, slipped in zip(turns, slips, strict=True)]
    held = SimpleNamespace(
        _body=SimpleNamespace(EvalPoseInWorld=lambda context: RigidTransform()),
        _context=None,
        _shake=Shake(),
        grips=grips,
        _poses=[RigidTransform() for _ in grips],
        _relative_pose=lambda turned: RigidTransform(RotationMatrix.MakeXRotation(np.radians(turned)), [0, 0, 0]),
    )
    assert _HeldBody._loss(held, {"finger": (np.zeros(3), 1.0)}) == ended
    assert _HeldBody._loss(held, {"finger": (np.zeros(3), 0.0)}) == "let go"
