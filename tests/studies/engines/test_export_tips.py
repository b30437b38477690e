"""Exported scenarios in MuJoCo compared with Drake."""

from pathlib import Path

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping

from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from studies.engines.export_tips import differences, drake_tips

TRIALS = (0, 4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides", "bar"),
    [
        ("free_bending", ["pressure.steps.all=[60e3, 150e3]"], 5e-6),  # 0.005 mm; the bar is 0.5 mm
        ("three_chambers", ["pressure.steps={all: [60e3], finger::left: [20e3]}"], 5e-6),
        ("box_grasp", ["pressure.steps.all=[50e3, 150e3]"], 1.5e-3),
        ("turned_box_grasp", ["pressure.steps.all=[50e3, 100e3]"], 1.5e-3),  # fingers that twist
        ("irregular_grasp", ["pressure.steps.all=[100e3]"], 1.5e-3),  # a mesh that is not convex
    ],
)
def test_tips_at_rest_are_those_of_drake(name, overrides, bar):
    pytest.importorskip("mujoco")
    assert differences(load_scenario(name, [*overrides, "record.truth=none"])).max() < bar


@pytest.mark.slow
def test_creep_and_laws_of_the_pressure_are_those_of_drake(tmp_path):
    """Tips at 3 and 6 s of a finger that creeps, and of one with a law; without either they are elsewhere."""
    pytest.importorskip("mujoco")
    creeping = write_creeping(FINGER, tmp_path, 0.3, 2.0)
    plain = Path(model_path(FINGER)).read_text(encoding="utf-8")
    with_law = tmp_path / "law.urdf"
    law = '<pressure_law pressure="-5e4 0 1e5 2e5" effective="-5e4 0 1.2e5 2.6e5"/></finger>'
    with_law.write_text(plain.replace("</finger>", law), encoding="utf-8")
    steps = [
        "pressure.steps.all=[100e3, 100e3]",
        "pressure.settle=2.9",
        "pressure.hold_samples=10",
        "record.truth=none",
    ]
    files = [f"models.left_finger.file={creeping}", f"models.right_finger.file={with_law}"]
    scenario = load_scenario("free_bending", [*steps, *files])
    assert differences(scenario, 0.002).max() < 5e-5  # creep follows angles that are held for 10 ms
    tips, bare = drake_tips(scenario), drake_tips(load_scenario("free_bending", steps))
    assert np.linalg.norm(tips - bare, axis=-1).min() > 5e-3
