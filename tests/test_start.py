"""What is imported at the start: what draws, reads meshes or makes tables is imported when it does so."""

import subprocess
import sys

import pytest

WHEN_USED = {
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
