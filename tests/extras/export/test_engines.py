"""Other engines take an exported file: MuJoCo Warp and Newton, on the CPU, where they are installed."""

import numpy as np
import pytest

from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.scenario.scenario_file import load_scenario

mujoco = pytest.importorskip("mujoco", reason="the extra `mujoco` is not installed")
# Their kernels are compiled at the first run, for many minutes.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def box_grasp(tmp_path_factory):
    """A file with steps of 2 ms: MuJoCo Warp has no noslip for the integrator of longer ones."""
    folder = tmp_path_factory.mktemp("box_grasp")
    export_mjcf(load_scenario("box_grasp"), folder, 0.002)
    return str(folder / "scenario.xml")


def test_newton_takes_masks_pairs_springs_and_chambers(box_grasp):
    newton = pytest.importorskip("newton", reason="newton is not installed: pip install newton")
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    builder.add_mjcf(box_grasp)
    taken = newton.solvers.SolverMuJoCo(builder.finalize(device="cpu"), use_mujoco_cpu=True).mj_model
    model = mujoco.MjModel.from_xml_path(box_grasp)
    assert (taken.nq, taken.nu, taken.ngeom, taken.npair, taken.ntendon) == (
        model.nq,
        model.nu,
        model.ngeom,
        model.npair,
        model.ntendon,
    )
    for field in ("geom_contype", "geom_conaffinity", "geom_solref", "geom_friction", "geom_solmix", "jnt_stiffness"):
        np.testing.assert_allclose(
            np.sort(getattr(taken, field), axis=None), np.sort(getattr(model, field), axis=None), rtol=1e-5
        )
    np.testing.assert_allclose(np.sort(taken.pair_solref, axis=None), np.sort(model.pair_solref, axis=None), rtol=1e-5)
