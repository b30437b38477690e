"""What a recording says about itself is enough to run it again."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

pytestmark = pytest.mark.slow

EVERYTHING = str(Path(__file__).parents[2] / "scenarios/one_of_everything.yaml")
SHORT = ["task=null", "pressure.settle=0.02"]


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A scenario, and its recording from a file."""
    scenario, path = load_scenario(EVERYTHING, SHORT), tmp_path_factory.mktemp("kept") / "recording.nc"
    simulate(scenario).save(path)
    return scenario, Recording.load(path)


def test_the_scenario_in_the_file_runs_again(kept, tmp_path):
    scenario, recording = kept
    path = tmp_path / "again.yaml"
    path.write_text(recording.data.attrs["scenario"])
    again = load_scenario(str(path))
    assert dump_scenario(again) == dump_scenario(scenario) == recording.data.attrs["scenario"]
    anew = simulate(again)
    for name in recording.data.data_vars:
        np.testing.assert_array_equal(anew[name], recording[name], err_msg=name)
