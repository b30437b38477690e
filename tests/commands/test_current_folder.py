"""No command runs a module of the folder in which it is started, or obeys settings there."""

import pytest
from command_line import short
from poisoned_folder import poison, run_in

from soft_gripper.commands.parser import CORE
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

OWN = """
import enum
from soft_gripper.estimators.named_estimators import find_estimator
make = find_estimator("arcs")
"""
QUICK = {
    "run": ["mine.yaml", *short("estimator.type=own_estimator.py:make")],
    "list": [],
    "show": ["mine.yaml", "--graphviz", "blocks.dot"],
    "expand": ["package://soft_gripper/grippers/finger.urdf", "-o", "plain.urdf"],
}
LONG = {"doctor": []}


@pytest.fixture
def folder(tmp_path):
    poison(tmp_path)
    (tmp_path / "mine.yaml").write_text(dump_scenario(load_scenario("free_bending")))
    (tmp_path / "own_estimator.py").write_text(OWN)
    return tmp_path


def test_commands_run_no_module_of_the_current_folder(folder):
    ended = run_in(folder, {name: [name, *words] for name, words in QUICK.items()})
    assert ended == {name: [0, []] for name in QUICK}


@pytest.mark.slow
def test_commands_that_take_long_run_none_either(folder):
    assert {*QUICK, *LONG} == {command.name for command in CORE}
    ended = run_in(folder, {name: [name, *words] for name, words in LONG.items()}, seconds=20)
    assert [name for name, (_, ran) in ended.items() if ran] == []
