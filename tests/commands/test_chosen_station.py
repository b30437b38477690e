"""The station that the options of a command name."""

from dataclasses import replace

import pytest

from soft_gripper.commands import chosen_station
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario_file import load_scenario


@pytest.mark.parametrize(("number", "said"), [(30, ""), (300, "note: reading 300 models, which may take minutes\n")])
def test_a_scenario_that_takes_long_to_build_says_so_first(number, said, monkeypatch, capsys):
    before_it_was_built = []

    def build(*_):
        before_it_was_built.append(capsys.readouterr().err)
        raise InputError("models", "file", "", "enough")

    scenario = load_scenario("box_grasp")
    monkeypatch.setattr(chosen_station, "make_station", build)
    with pytest.raises(InputError):
        chosen_station.station_of("box_grasp", replace(scenario, models=number * scenario.models[:1]))
    assert before_it_was_built == [said]
