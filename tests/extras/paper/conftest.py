"""What tests of the evaluation share: a short scenario, and what a run of it leaves."""

from pathlib import Path

import pytest

from soft_gripper.extras.paper.scenario_run import run_scenario
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

SHORT = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> str:
    """A scenario file: free bending in two steps of a quarter of a second."""
    file = tmp_path_factory.mktemp("scenario") / "short.yaml"
    file.write_text(dump_scenario(load_scenario("free_bending", SHORT)))
    return str(file)


@pytest.fixture(scope="module")
def folder(short, tmp_path_factory) -> Path:
    """What a run of it leaves."""
    folder = tmp_path_factory.mktemp("results") / "short"
    run_scenario(short, folder)
    return folder
