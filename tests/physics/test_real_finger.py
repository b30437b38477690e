"""Fingers with all that makes them real, in whole scenarios: both kinds of plant, on an arm, at Drake's own speed."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario

REAL = """
<creep share="0.2 0.1" time="0.3 4"/>
<pressure_law pressure="-5e4 0 1e5 2e5" effective="-5e4 0 1.05e5 2.3e5"/>
<tip_load mass="0.01" xyz="0 0 -0.005"/>
</finger>"""
OF_SILICONE = 'youngs_modulus="2.67e5" density="1070"'
SHORT = ["pressure.steps.all=[20e3, 60e3]", "pressure.settle=0.3", "pressure.hold_samples=2"]


@pytest.fixture
def real(tmp_path):
    """Writes a shipped gripper with real fingers beside the test."""

    def write(name: str) -> Path:
        text = (DIRECTORY / "grippers" / name).read_text().replace("</finger>", REAL)
        text = text.replace(OF_SILICONE, 'material="dragon_skin_10"').replace("<body", '<body shear_factor="0.857"')
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def overrides(scenario, real):
    models = load_scenario(scenario).models
    return [f"models.{i}.file={real(Path(m.file).name)}" for i, m in enumerate(models) if "/grippers/" in m.file]


@pytest.mark.slow
def test_a_grasp_comes_out_alike_in_both_kinds_of_plant(real):
    changes = [*SHORT, *overrides("box_grasp", real)]
    angles = []
    for step in (0.005, 0.0):
        last = simulate(load_scenario("box_grasp", [*changes, f"plant_config.time_step={step}"])).data.isel(time=-1)
        angles.append(last["left_finger.sampled_joint_angles"].values)
    np.testing.assert_allclose(*angles, atol=5e-4)
    assert np.abs(angles[0]).max() > 0.05


@pytest.mark.slow
def test_an_arm_carries_it(real):
    scenario = load_scenario("pick_and_place_box", overrides("pick_and_place_box", real))
    station = make_station(scenario)
    context = station.diagram.CreateDefaultContext()
    assert np.isfinite(station.plant.GetPositionsAndVelocities(station.plant.GetMyContextFromRoot(context))).all()
