"""A bottle is lifted by its neck: its hull is wider there, so one touched at its hull would slide and turn."""

import numpy as np
import pytest
import trimesh

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.scenario.scenario_file import load_scenario

NECK, BODY, SHOULDER, HEIGHT, MASS = 0.010, 0.020, 0.06, 0.12, 0.06  # radii, heights, m; kg
CHANGES = ("models.gantry.X_PC.translation=[0, 0, 0.26]", f"models.bottle.mass={MASS}", "models.bottle.friction=0.8")
SLIDES = 1.5e-3  # m, in MuJoCo too, where a held object creeps more


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The bottle as a bare mesh, and in files of three formats that name it."""
    folder = tmp_path_factory.mktemp("bottles")
    profile = [[0, 0], [BODY, 0], [BODY, SHOULDER], [NECK, SHOULDER + 0.01], [NECK, HEIGHT], [0, HEIGHT]]
    trimesh.creation.revolve(profile, sections=48).export(folder / "bottle.obj")
    inertia = f"<mass>{MASS}</mass><inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>2e-5</izz></inertia>"
    texts = {
        "urdf": f"""<robot name='b'><link name='b'><inertial><origin xyz='0 0 0.05'/><mass value='{MASS}'/>
            <inertia ixx='1e-4' iyy='1e-4' izz='2e-5' ixy='0' ixz='0' iyz='0'/></inertial>
            <collision><geometry><mesh filename='bottle.obj'/></geometry></collision></link></robot>""",
        "sdf": f"""<sdf version='1.7'><model name='b'><link name='b'><inertial><pose>0 0 0.05 0 0 0</pose>{inertia}
            </inertial><collision name='c'><geometry><mesh><uri>bottle.obj</uri></mesh></geometry></collision>
            </link></model></sdf>""",
        "xml": f"""<mujoco model='b'><asset><mesh name='m' file='bottle.obj'/></asset><worldbody><body name='b'>
            <freejoint/><inertial pos='0 0 0.05' mass='{MASS}' diaginertia='1e-4 1e-4 2e-5'/>
            <geom type='mesh' mesh='m'/></body></worldbody></mujoco>""",
    }
    for suffix, text in texts.items():
        (folder / f"bottle.{suffix}").write_text(text)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "engine"), [("obj", "drake"), ("urdf", "drake"), ("sdf", "drake"), ("xml", "drake"), ("urdf", "mujoco")]
)
def test_a_bottle_is_lifted_by_its_neck(files, suffix, engine):
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    changes = [*CHANGES, f"models.bottle.file={files / f'bottle.{suffix}'}", f"engine={engine}"]
    recording = simulate(load_scenario("bottle_grasp", changes))
    assert recording["grip.true_object_width"].values[-1] == pytest.approx(
        2 * NECK, abs=1.5e-3
    )  # the skin gives way, more in MuJoCo; the hull is 36 mm wide there
    arm, pose = recording["gantry.joint_positions"].values, recording["bottle.pose"].values
    lift = pose[-1, 6] - pose[0, 6]
    assert lift > 0.07
    assert abs(lift - (arm[-1] - arm[0])[1]) < SLIDES
    turn = 2 * np.arccos(min(1.0, abs(pose[0, :4] @ pose[-1, :4])))
    assert np.degrees(turn) < 0.5
