"""The page on MuJoCo prints what benchmarks/engine_agreement.py wrote, to the last digit, of every shipped scenario."""

import re

from engine_agreement import HEADING, PAGE, TABLE, Agreement, page_table

from soft_gripper.files.row_table import read_csv
from soft_gripper.scenario.deformables import is_deformable
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names

LINES = PAGE.read_text(encoding="utf-8").splitlines()
ROWS = read_csv(TABLE, Agreement)


def test_the_table_is_what_was_written():
    start = LINES.index(HEADING[0])
    assert LINES[start : LINES.index("", start)] == page_table(ROWS)


def test_every_scenario_of_rigid_objects_has_been_run():
    scenarios = {name: load_scenario(name) for name in scenario_names()}
    rigid = [name for name, each in scenarios.items() if not any(is_deformable(model.mesh) for model in each.models)]
    assert [row.scenario for row in ROWS] == rigid


def test_scenarios_that_touch_nothing_are_named():
    (sentence,) = re.findall(r"In (.*), which touch nothing, tips agree to 0\.00 mm", "\n".join(LINES))
    free = [row for row in ROWS if row.force_percent == 0]
    assert re.findall(r"`(\w+)`", sentence) == [row.scenario for row in free]
    assert all(f"{row.tips_mm:.2f}" == "0.00" for row in free)
