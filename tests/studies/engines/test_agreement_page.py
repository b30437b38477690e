"""The page on MuJoCo prints what the study `engine-agreement` wrote, to the last digit, of every shipped scenario."""

from types import SimpleNamespace

import numpy as np
import pytest

from soft_gripper.files.row_table import read_csv
from soft_gripper.scenario.deformables import is_deformable
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names
from studies.engines import engine_agreement
from studies.engines.engine_agreement import (
    BOXES,
    CREEP,
    CREEP_HEADING,
    HEADING,
    MIN_CREEP_MASS,
    PAGE,
    TABLE,
    Box,
    Creep,
    EngineAgreement,
    count_ends,
    creep_table,
    page_table,
)

LINES = PAGE.read_text(encoding="utf-8").splitlines()
ROWS = read_csv(TABLE, EngineAgreement)


def test_the_table_is_what_was_written():
    start = LINES.index(HEADING[0])
    assert LINES[start : LINES.index("", start)] == page_table(ROWS)


def test_every_scenario_of_rigid_objects_has_been_run():
    scenarios = {name: load_scenario(name) for name in scenario_names()}
    rigid = [name for name, each in scenarios.items() if not any(is_deformable(model.mesh) for model in each.models)]
    assert [row.scenario for row in ROWS] == rigid


def test_the_page_says_how_boxes_end():
    """Both hold all of them: friction could carry their weight, whatever the table carries."""
    boxes, page = read_csv(BOXES, Box), " ".join(LINES)
    (alike,) = count_ends(boxes)
    assert (alike.in_drake, alike.in_mujoco) == ("held", "held")
    assert f"--boxes {len(boxes)}" in page
    assert f"All {alike.boxes} end alike, held in both" in page
    assert f"is at most {alike.largest_weight_over_friction:.2f} of the friction available" in page
    sinking = next(box for box in boxes if box.mass_kg > MIN_CREEP_MASS)
    assert f"of {1e3 * sinking.mass_kg:.0f} g and friction {sinking.friction:.2f}" in page


def test_the_page_says_how_a_box_sinks():
    """In Drake less the shorter the step, as far as in MuJoCo, where friction at rest does not creep."""
    rows = read_csv(CREEP, Creep)
    start = LINES.index(CREEP_HEADING[0])
    assert LINES[start : LINES.index("", start)] == creep_table(rows)
    coarse, tight, *finer, mujoco = rows
    assert tight.sinking_in_1_s_mm == pytest.approx(coarse.sinking_in_1_s_mm, abs=0.001)
    assert coarse.lifted_mm < finer[0].lifted_mm < finer[1].lifted_mm < finer[2].lifted_mm < mujoco.lifted_mm
    assert {row.end for row in finer} == {"held"}
    assert finer[-1].sinking_in_1_s_mm < coarse.sinking_in_1_s_mm / 2
    assert abs(mujoco.sinking_in_1_s_mm) < 0.001


def test_weight_is_compared_with_the_friction_of_all_fingers(monkeypatch):
    """1 N on two fingers that press with 1 and 2 N, friction 0.5 and 0.25."""
    time = np.arange(0, 1, 0.01)
    normal = np.tile([1.0, 2.0], (len(time), 1))
    signals = SimpleNamespace(time=time, normal=normal, coefficients=np.array([0.5, 0.25]), weight=1.0)
    monkeypatch.setattr(engine_agreement, "RecordedObject", lambda *_: SimpleNamespace(signals=signals))
    assert engine_agreement.weight_over_friction(None, None) == pytest.approx(1.0)
