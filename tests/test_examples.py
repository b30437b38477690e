"""The files of examples/own_diagram: short, running as they stand, and shown in notebook 06."""

import runpy
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = {path.stem: path for path in sorted((ROOT / "examples" / "own_diagram").glob("*.py"))}
NOTEBOOK = nbformat.read(ROOT / "notebooks" / "06_your_own_diagram.ipynb", as_version=4)


@pytest.fixture(scope="module")
def run():
    """What a file leaves behind, run as `python FILE` would."""

    def run_file(name, done={}):  # noqa: B006
        if name not in done:
            sys.path.insert(0, str(EXAMPLES[name].parent))
            try:
                done[name] = runpy.run_path(str(EXAMPLES[name]), run_name="__main__")
            finally:
                sys.path.pop(0)
        return done[name]

    return run_file


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_is_short_and_runs(run, name):
    assert len(EXAMPLES[name].read_text().splitlines()) <= 60  # of 76 columns, as ruff checks
    assert run(name)["figure"].axes


@pytest.mark.parametrize("name", EXAMPLES)
def test_is_shown_in_the_notebook(name):
    """As it stands, or imported: a notebook defines nothing."""
    _, _, code = EXAMPLES[name].read_text().split('"""', 2)
    shown = code.strip() if "\n    def " not in code else f"from own_diagram.{name} import"
    assert any(shown in cell.source for cell in NOTEBOOK.cells)


@pytest.mark.slow
def test_all_outputs_of_the_own_sensor_are_logged(run):
    recording = run("own_sensor")["recording"]
    assert recording["left_finger.temperature"].attrs["units"] == "degC"
    assert recording["left_finger.saturated"].dims == ("time", "path", "section")
    assert recording["left_finger.saturated"].values.max() == 1.0
    drift, temperature = (float(recording[f"left_finger.{name}"][-1]) for name in ("drift", "temperature"))
    assert drift == pytest.approx(2e-4 * (temperature - 20))


@pytest.mark.slow
def test_the_pressure_is_stepped_at_20_hz_until_the_fingers_touch(run):
    found = run("external_pressure")
    command = found["recording"]["left_finger.pressure_command"].values
    changes = np.flatnonzero(np.diff(command))
    assert set(np.diff(changes)) == {5}  # samples of 10 ms
    assert command[-1] == found["pressure"]["left_finger"]
    assert float(found["recording"]["left_finger.external_torque"][-1, 0]) == pytest.approx(-found["TOUCH"], abs=6e-3)
    assert found["recording"]["left_finger.contact"].values[-1] == 1


@pytest.mark.slow
def test_three_fingers_hold_the_apple_with_the_torque_limit(run):
    recording = run("three_fingers")["recording"]
    assert float(recording["grip.torque"][-1]) == pytest.approx(0.05, rel=0.02)
    assert all(recording[f"finger_{i}.contact"].values[-1] == 1 for i in (1, 2, 3))
    middle = recording["apple.pose"].values[-1, 4:6]
    assert np.linalg.norm(middle) < 1e-3


def test_drakes_logger_and_the_port_give_the_same(run):
    found = run("drake_logger")
    np.testing.assert_array_equal(found["log"].data()[:, -1], found["now"])
    assert np.isfinite(found["now"]).all()
