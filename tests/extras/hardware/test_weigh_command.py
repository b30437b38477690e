"""soft-gripper weigh as a user calls it: files like those of the published trunk, made by its model."""

import numpy as np
import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from hardware_files import DESCRIPTION, swinging, write_csv
from refusals import refusal

from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.settled_states import (
    SettledStates,
    predicted_markers,
    resting_positions,
)
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.model_files import model_path

FINGER = "package://soft_gripper/recordings/soft_trunk.urdf"
LOAD = 0.15  # kg


def disks_under(load: float, angles, finger: Finger):
    """Markers of the trunk, x, y and z of the file, (R, 9), at angles of its motors, (R, 6) degrees."""
    wound = 0.02 * np.radians(angles)
    rows, none = len(angles), np.zeros((3, 3))
    states = SettledStates(
        "made",
        np.concatenate([wound, -wound], axis=1),
        np.zeros((rows, 3, 3)),
        none,
        np.full(rows, ""),
        np.array([0, 0, 9.81]),
        np.array([0.345, 0.64, 1.0]),
        load,
    )
    p, _ = predicted_markers(finger, states, resting_positions(Model(finger), states))
    return np.stack([p[..., 0] + 0.1, -p[..., 2], p[..., 1] + 0.105], axis=-1).reshape(rows, 9)


@pytest.mark.slow
def test_files_and_table(tmp_path):
    """A load that the file's name gives wrongly is estimated from the disks."""
    every, time = 60, np.arange(0, 6000, 60)
    angles = np.sin(time[:, None] * np.arange(1, 7) / 700) * np.array([40, 60, 20, 60, 20, 40])
    disks = disks_under(LOAD, angles, read_finger(model_path(FINGER)))
    values = np.column_stack([time, disks, angles])
    names = ["ID", *(f"{axis}{disk}" for disk in (1, 2, 3) for axis in "xyz"), *(f"phi{i}" for i in range(1, 7))]
    between = np.repeat(values, every, axis=0)  # rows that are not used
    between[:, 0] = np.arange(len(between))
    file = write_csv(tmp_path / "made_400g.csv", dict(zip(names, between.T, strict=True)))
    out = tmp_path / "out"
    outcome = soft_gripper("weigh", file, "--as", "soft_trunk", "--finger", FINGER, "--out", out)
    assert outcome.code == 0, outcome.err
    rows = csv_rows(out / "weigh.csv")
    assert [int(row["rows"]) for row in rows] == [50, 50, 100]
    np.testing.assert_allclose([float(row["load_g"]) for row in rows], 1e3 * LOAD, atol=0.1)
    assert {float(row["named_g"]) for row in rows} == {400.0}
    assert {path.name for path in out.iterdir()} == {"weigh.csv", "weigh.png", "weigh.svg"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.csv", "--as", "soft_trunk", "--finger", FINGER], "there is no such file here"),
        (["run.csv", "--as", "described.yaml", "--finger", FINGER], "only recordings of settled states are weighed"),
    ],
)
def test_mistakes_are_named(tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "run.csv", swinging())
    (tmp_path / "described.yaml").write_text(DESCRIPTION)
    assert said in refusal("weigh", *arguments)
