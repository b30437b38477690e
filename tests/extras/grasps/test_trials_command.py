"""soft-gripper study grasp-trials: whole trials, one alone, processes, Ctrl-C, and what it refuses."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper
from pick_and_place import LOOKED_FOR
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.grasps.adds import TrialsConfig
from soft_gripper.extras.grasps.trial import draw, random_numbers
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

BOX = (["qw", "qx", "qy", "qz"], ["x", "y", "z"])  # in the state of the plant


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[..., Path]:
    """Writes `pick_and_place_box` with contact looked for, and other changes, to a file."""

    def write(*changes: str, name: str = "box") -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(dump_scenario(load_scenario("pick_and_place_box", [LOOKED_FOR, *changes])))
        return path

    return write


@pytest.mark.slow
def test_a_trial_alone_places_the_box_and_keeps_what_it_takes_to_look_into_it(scenario, tmp_path):
    done = soft_gripper(
        "study", "grasp-trials", "--scenario", scenario(), "--trial", "4", "--seed", "2", "--out", tmp_path
    )
    assert done.code == 0
    printed = {line[:21].strip(): line[21:] for line in done.out.splitlines() if line[20:21] == " "}
    assert (printed["success"], printed["dropped"], printed["cause"]) == ("True", "False", "")
    recording = Recording.load(tmp_path / "box_4" / "recording.nc")
    kept = load_scenario(str(tmp_path / "box_4" / "scenario.yaml"))
    drawn = draw(random_numbers(2, "box", 4), TrialsConfig())
    assert kept.models[3].mass == pytest.approx(1e-3 * drawn.mass_g)
    box = recording["plant.state"].sel(state=["box_box_x", "box_box_y", "box_box_z"]).values
    start = np.array([0.45 + 1e-3 * drawn.x_mm, -0.18 + 1e-3 * drawn.y_mm, 0.03 * drawn.size + 1e-5])
    np.testing.assert_allclose(box[0], start, atol=1e-9)
    error = kept.task.pose_error
    drawn_error = (1e-3 * drawn.error_x_mm, 1e-3 * drawn.error_y_mm, np.radians(drawn.error_yaw_deg))
    assert (error.x, error.y, error.yaw) == pytest.approx(drawn_error)
    assert float(printed["reported_x_mm"]) == pytest.approx(drawn.x_mm + drawn.error_x_mm, abs=1e-3)
    q = recording["plant.state"].sel(state=[f"box_box_{name}" for name in BOX[0]]).values[-1]
    X_WGoal = kept.task.X_WGoal.GetDeterministicValue()
    turned = RotationMatrix(Quaternion(q / np.linalg.norm(q))) @ X_WGoal.rotation().inverse()
    assert float(printed["placed_angle_deg"]) == pytest.approx(np.degrees(abs(turned.ToAngleAxis().angle())), abs=1e-3)
    assert float(printed["placed_error_mm"]) == pytest.approx(
        1e3 * np.linalg.norm(box[-1] - X_WGoal.translation()), abs=1e-3
    )
    forces = [recording[f"{finger}_finger.normal_force"].values for finger in ("left", "right")]
    held = int(np.argmax(recording["task.phase"].values == 3))  # lift
    q, p = (recording["plant.state"].sel(state=[f"box_box_{name}" for name in names]).values[held] for names in BOX)
    X_OW = RigidTransform(Quaternion(q / np.linalg.norm(q)), p).inverse()
    for finger in ("left", "right"):
        x, _, z = X_OW @ recording[f"{finger}_finger.contact_center"].values[held]
        assert abs(x) == pytest.approx(0.022 * drawn.size, abs=2e-4)
        assert abs(z) < 0.03 * drawn.size
    weight = kept.models[3].mass * 9.81
    assert float(printed["peak_force_n"]) == pytest.approx(np.max(forces), abs=1e-3)
    assert np.max(forces) > weight / 2 / kept.models[3].friction
