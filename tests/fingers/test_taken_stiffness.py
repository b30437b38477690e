"""A pressure that takes a part of a finger's stiffness: in the plant, in balance, and in what estimators assume."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from finger_plants import free_bending, uniform_finger
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.fingers.finger_parts import CreepBranch, ElasticLaw, PressureLaw
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import free_bending_angles, resting_angles
from soft_gripper.fingers.taken_stiffness import TakenStiffness, taken_torque
from soft_gripper.models import DIRECTORY

HIGHEST, GAIN, MARGIN = 60e3, 0.8, 0.4  # Pa, and of the law below
LAW = PressureLaw((-HIGHEST, 0.0, HIGHEST), (-GAIN * HIGHEST, 0.0, GAIN * HIGHEST), (0.0, 0.0, 1 - MARGIN))
ELEMENT = (
    f'<pressure_law pressure="{-HIGHEST} 0 {HIGHEST}" effective="{-GAIN * HIGHEST} 0 {GAIN * HIGHEST}" '
    f'stiffness_taken="0 0 {1 - MARGIN}"/>'
)
CREEP = '<creep share="0.1" time="0.05"/>'
PRESSURES = [20e3, 60e3]


def gripper(folder: Path, *elements: str) -> list[str]:
    """Overrides for a scenario whose fingers have further elements."""
    text = (DIRECTORY / "grippers/finger.urdf").read_text()
    file = folder / "finger.urdf"
    file.write_text(text.replace("</finger>", f"{''.join(elements)}</finger>"))
    return [f"models.{i}.file={file}" for i in (0, 1)] + [f"pressure.maximum={HIGHEST}"]


def test_without_weight_a_finger_bends_by_a_hyperbola(tapered_finger):
    """g p / (1 - p / c) with the c at which nothing would be left of the stiffness, and of a vacuum g p."""
    finger, balloons = replace(tapered_finger, pressure_law=LAW), HIGHEST / (1 - MARGIN)
    p = np.array([-4e4, 0.0, 1e4, HIGHEST, 8e4])
    expected = GAIN * p / np.where(p > 0, 1 - p / balloons, 1.0)
    found = free_bending_angles(finger, p)
    np.testing.assert_allclose(found, expected[:, None] * tapered_finger.pressure_gain / tapered_finger.stiffness)
    np.testing.assert_allclose(LAW.bend(p), expected)


def test_a_finger_in_balance_is_driven_by_what_pressure_takes(shipped_finger):
    """Springs of the whole stiffness hold pressure, weight, what creep remembers and what pressure takes."""
    finger = replace(shipped_finger, pressure_law=LAW, creep=(CreepBranch(0.1, 1.0),))
    for pressure in (-20e3, 0.0, 40e3):
        q = resting_angles(finger, pressure, -6 - 7j)
        known = finger.pressure_torque(pressure) + gravity_torque(finger, q, np.array(-6 - 7j))
        driven = known + 0.1 * finger.stiffness * q + taken_torque(finger, q, pressure)
        np.testing.assert_allclose(finger.elastic_torque(q), driven, atol=1e-9)


def test_the_block_is_the_torque_at_any_state_and_pressure(finger_plant):
    finger = replace(uniform_finger(3), pressure_law=LAW)
    plant = finger_plant(finger, 0.004)
    block = TakenStiffness(PlantFinger(finger, plant, plant.GetModelInstanceByName("robot")))
    context = block.CreateDefaultContext()
    for pressure in (-3e4, 0.0, 2e4, 8e4):
        q = np.random.default_rng(1).uniform(-0.4, 0.4, 3)
        block.GetInputPort("state").FixValue(context, [*q, 1.0, -2.0, 3.0])
        block.GetInputPort("pressure").FixValue(context, [pressure])
        found = block.GetOutputPort("actuation").Eval(context)
        np.testing.assert_allclose(found, taken_torque(finger, q, pressure), atol=1e-15)


@pytest.mark.parametrize(
    "change",
    [
        {"elastic_law": ElasticLaw((-10.0, 10.0), (-1.0, 1.0), (-1.0, 1.0))},
        {"yields": ("bending", "stretch")},
    ],
    ids=str,
)
def test_only_a_linear_finger_in_its_plane_has_it(tapered_finger, change):
    with refused("pressure_law.stiffness_taken", LAW.stiffness_taken):
        replace(tapered_finger, pressure_law=LAW, **change)


@pytest.mark.parametrize(
    ("taken", "field"),
    [
        ((0.0, 0.5), "pressure_law.stiffness_taken"),
        ((0.0, 0.1, 0.5), "pressure_law.stiffness_taken"),
        ((0.0, 0.0, 1.0), "pressure_law.stiffness_taken[2]"),
    ],
)
def test_wrong_shares_are_refused(tapered_finger, taken, field):
    with refused(field):
        replace(tapered_finger, pressure_law=replace(LAW, stiffness_taken=taken))


def test_a_supply_that_would_balloon_a_finger_is_refused(tmp_path):
    """It leaves 0.1 of the stiffness at 90 kPa, which creep takes."""
    files = gripper(tmp_path, ELEMENT, CREEP)
    make_station(free_bending([HIGHEST], 1.0, *files, "pressure.maximum=89e3"))
    with refused("maximum", 91e3):
        make_station(free_bending([HIGHEST], 1.0, *files, "pressure.maximum=91e3"))


def test_a_station_bends_it_so_and_its_estimators_know(tmp_path, shipped_finger):
    """Hanging at rest: the turn of `resting_angles` within 0.1 %, and next to no external torque."""
    settled = ("plant_config.time_step=0.005", *gripper(tmp_path, ELEMENT, CREEP))
    recording = simulate(free_bending(PRESSURES, 1.2, *settled)).data.sel(time=[1.2, 2.4], method="nearest")
    finger = replace(shipped_finger, pressure_law=LAW, creep=(CreepBranch(0.1, 0.05),))
    expected = resting_angles(finger, np.array(PRESSURES), 9.81 + 0j)
    for side in ("left_finger", "right_finger"):
        q = recording[f"{side}.sampled_joint_angles"].values
        np.testing.assert_allclose(q.sum(axis=1), expected.sum(axis=1), rtol=1e-3)
        assert np.abs(recording[f"{side}.external_torque"]).max() < 1e-3 * np.abs(finger.stiffness * q).max()
