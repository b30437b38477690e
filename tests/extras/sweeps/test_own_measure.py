"""A measure of one's own in a sweep, as the docs show it, and what is refused."""

import csv
import re
from pathlib import Path

import pytest
from command_line import short, soft_gripper

from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.measured_runs import run_and_measure

DOCS = Path(__file__).parents[3] / "docs" / "sweeps.md"
NAME = "largest_bend_rate_deg_s"
BRIEF = {"pressure.steps": {"all": [0.0, 60e3]}, "pressure.settle": 0.1, "pressure.hold_samples": 5}


@pytest.fixture(autouse=True)
def own(tmp_path, monkeypatch):
    """The module of the docs, and one of mistakes, in the current folder."""
    (code,) = (block for block in re.findall(r"```python\n(.*?)```", DOCS.read_text(), re.DOTALL) if NAME in block)
    (tmp_path / "my_measures.py").write_text(code)
    (tmp_path / "my_mistakes.py").write_text(
        "def fails(station, recording):\n    return 1 / 0\n\n\n"
        "def lists(station, recording):\n    return [1, 2]\n\n\n"
        "def largest_bend_deg(station, recording):\n    return 1.0\n"
    )
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_a_measure_of_ones_own_is_a_column(tmp_path):
    """Of a finger that bends faster the softer it is."""
    measure = ["--measure", f"my_measures:{NAME}"]
    vary = ["--vary", "models.0.fingers.all.youngs_modulus=-30 %,+30 %", "--jobs", 1, "--out", "out"]
    done = soft_gripper("sweep", "free_bending", *short(), *measure, *vary)
    assert done.code == 0, done.err
    with Path("out/sweep.csv").open(newline="") as file:
        soft, stiff = csv.DictReader(file)
    assert list(soft)[-2:] == [NAME, "error"]
    assert float(soft[NAME]) > 1.2 * float(stiff[NAME]) > 0
    assert float(soft["largest_bend_deg"]) > float(stiff["largest_bend_deg"])


@pytest.mark.parametrize("function", ["fails", "lists"])
def test_a_measure_that_fails_or_returns_no_value_is_named(function):
    with pytest.raises(InputError) as error:
        run_and_measure("free_bending", BRIEF, [f"my_mistakes:{function}"])
    assert (error.value.field, error.value.value) == ("--measure", f"my_mistakes:{function}")


@pytest.mark.parametrize("name", ["my_measures", "my_measures:nothing", "nowhere:f", "my_mistakes:largest_bend_deg"])
def test_what_is_no_measure_is_refused_before_anything_runs(name):
    done = soft_gripper(*["sweep", "free_bending", "--vary", "sensor.seed=1,2", "--out", "out", "--measure"], name)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert f"--measure = '{name}'" in done.err
    assert not Path("out").exists()
