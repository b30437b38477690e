"""Fingers with all that makes them real, and regimes of the grip control, in whole scenarios."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.models import DIRECTORY
from soft_gripper.runs.scores.steps import StepRow, step_table
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


SHIPPED = load_scenario("tip_distance_steps").control


def largest_step() -> list[float]:
    """The set points before and after the largest step of the scenario."""
    points = SHIPPED.set_points
    return max(([a, b] for a, b in pairwise(points)), key=lambda step: abs(step[1] - step[0]))


def with_integral_gain(factor: float) -> StepRow:
    """How the opening follows that step with a multiple of the shipped integral gain."""
    changes = [f"control.set_points={largest_step()}", f"control.gains.ki={factor * SHIPPED.gains.ki}"]
    station = make_station(load_scenario("tip_distance_steps", changes))
    return step_table(station, run_station(station))[-1]


@pytest.mark.slow
def test_the_first_rings_the_second_is_well_damped_and_the_third_creeps() -> None:
    """Of the rings at least two lie beyond the set point and two before it; all settle, the shipped gains soonest."""
    ringing, shipped, creeping = map(with_integral_gain, (3.0, 1.0, 0.3))
    assert ringing.overshoot_percent > 30
    assert ringing.crossings >= 4
    assert shipped.overshoot_percent < 5
    assert shipped.crossings <= 1
    assert creeping.overshoot_percent == 0
    assert creeping.crossings == 0
    assert ringing.settling_s > 1.5 * shipped.settling_s
    assert creeping.settling_s > 2 * shipped.settling_s
