"""Other engines take an exported file: MuJoCo Warp and Newton, on the CPU, where they are installed."""

import numpy as np
import pytest

from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.scenario.scenario_file import load_scenario

mujoco = pytest.importorskip("mujoco", reason="the extra `mujoco` is not installed")
# Their kernels are compiled at the first run, for many minutes.
pytestmark = pytest.mark.slow
STEPS = 60


@pytest.fixture(scope="module")
def box_grasp(tmp_path_factory):
    """A file with steps of 2 ms: MuJoCo Warp has no noslip for the integrator of longer ones."""
    folder = tmp_path_factory.mktemp("box_grasp")
    export_mjcf(load_scenario("box_grasp"), folder, 0.002)
    return str(folder / "scenario.xml")


def test_mujoco_warp_moves_as_mujoco_does(box_grasp):
    warp = pytest.importorskip("mujoco_warp", reason="mujoco-warp is not installed: pip install mujoco-warp")
    model = mujoco.MjModel.from_xml_path(box_grasp)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = 100e3
    of_warp = warp.put_data(model, data, nconmax=64, njmax=512)
    taken = warp.put_model(model)
    for _ in range(STEPS):
        warp.step(taken, of_warp)
    mujoco.mj_step(model, data, STEPS)
    assert np.abs(data.qpos[:24]).max() > 0.01
    np.testing.assert_allclose(of_warp.qpos.numpy()[0], data.qpos, atol=1e-5)


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
