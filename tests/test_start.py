"""What is imported at the start: what draws, reads meshes or makes tables is imported when it does so."""

import subprocess
import sys

import pytest

WHEN_USED = {  # but for matplotlib itself, which Drake's visualization imports
    *("matplotlib.figure", "matplotlib.axes", "PIL.ImageDraw", "trimesh", "pandas", "xarray", "h5netcdf", "h5py"),
    *("scipy", "scipy.linalg", "scipy.optimize", "scipy.sparse", "scipy.spatial", "scipy.special"),
}


def _imported(*lines):
    """The modules that a script imports in a process of its own."""
    script = "\n".join([*lines, "import sys", "print(*sys.modules)"])
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(found.stdout.split())


@pytest.mark.parametrize("name", ["simulate", "load_scenario", "make_station", "Recording"])
def test_a_public_name_loads_nothing_that_draws_reads_meshes_or_makes_tables(name):
    assert _imported("import soft_gripper as sg", f"sg.{name}") & WHEN_USED == set()


def test_a_refused_value_is_answered_before_what_simulates_is_imported():
    """Nor is anything that a run alone needs."""
    command = "run", "free_bending", "--set", "pressure.settle=-1"
    modules = _imported("from soft_gripper.commands import main", f"assert main({command}) == 2")
    assert modules & (WHEN_USED | {"soft_gripper.diagrams.simulation", "soft_gripper.commands.run"}) == set()


@pytest.mark.parametrize("words", [["--help"], ["list"]])
def test_help_and_lists_import_neither_drake_nor_numpy(words):
    run = f"try:\n    main({words})\nexcept SystemExit:\n    pass"
    assert _imported("from soft_gripper.commands import main", run) & {"numpy", "pydrake"} == set()


def test_the_command_that_runs_a_scenario_draws_only_when_it_does():
    assert _imported("import soft_gripper.commands.run") & WHEN_USED == set()
