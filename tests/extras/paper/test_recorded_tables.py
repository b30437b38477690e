"""Recorded tables: what the scenario's own estimator made of its own sensors, and what a wrong nominal costs."""

from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.section_tables import force_table, pose_table
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.runs.scores.external_torques import recorded_force_table
from soft_gripper.runs.scores.poses import held_samples, recorded_pose_table
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ["pressure.steps.all=[60e3, -30e3, 120e3]", "pressure.settle=0.5", "pressure.hold_samples=10"]
# Of silicone and layer alike: the neutral axis, and so what the sensors say, stays.
STIFFER = ("nominal.finger.youngs_modulus='+10 %'", "nominal.finger.layer_modulus='+10 %'")
RUNS = {
    "four sections": ("free_bending", []),
    "three sections": ("obstructed_inside", ["sensor.sections=3"]),
    "one side": ("box_grasp", ["sensor.one_sided=true", "sensor.sections=2"]),
    "a wrong nominal": ("free_bending", [*STIFFER, "nominal.finger.sensor_spacing='+5 %'"]),
}
STRAIGHT = """
from pydrake.systems.framework import LeafSystem

class Straight(LeafSystem):
    def __init__(self, layout, gravity, period):
        super().__init__()
        joints = layout.finger.segments
        self.DeclareVectorOutputPort("estimated_joint_angles", joints, lambda context, output: output.SetZero())
"""
Run = tuple[Station, Recording]


def run_of(name: str, *overrides: str) -> Run:
    station = make_station(load_scenario(name, [*STEPS, *overrides]))
    return station, run_station(station)


def compare(rows: Sequence[Any], others: Sequence[Any]) -> None:
    """Fails unless names and counts are the same and numbers equal but for rounding."""
    assert len(rows) == len(others) > 0
    for row, other in zip(rows, others, strict=True):
        for value, expected in zip(astuple(row), astuple(other), strict=True):
            if isinstance(expected, float):
                assert value == pytest.approx(expected, rel=1e-9, abs=1e-9)
            else:
                assert value == expected


@pytest.mark.slow
@pytest.mark.parametrize(("name", "overrides"), RUNS.values(), ids=RUNS)
def test_recorded_tables_are_those_read_again_for_as_many_sections(name: str, overrides: list[str]) -> None:
    station, recording = run_of(name, *overrides)
    sections = [station.scenario.sensor.sections]
    compare(recorded_pose_table("run", station, recording), pose_table("run", station, recording, sections))
    compare(recorded_force_table("run", station, recording), force_table("run", station, recording, sections))


def test_a_nominal_model_has_its_name_in_every_row() -> None:
    station, recording = run_of("free_bending", *STIFFER, "nominal.response=[[0.9, -0.1], [1.1, 0.1]]")
    tables = (
        recorded_pose_table("run", station, recording),
        recorded_force_table("run", station, recording),
        pose_table("run", station, recording, [1, 4]),
        force_table("run", station, recording, [1, 4]),
    )
    for rows in tables:
        assert {row.nominal for row in rows} == {"youngs_modulus +10 %; layer_modulus +10 %; response"}


def test_a_finger_believed_too_stiff_seems_to_be_pushed_by_what_its_elasticity_is_wrong() -> None:
    """Nothing is touched; what the sections bend beyond the expected must come from outside, and most at the base."""
    station, recording = run_of("free_bending", *STIFFER)
    for rows in (recorded_force_table("run", station, recording), force_table("run", station, recording, [4])):
        for finger in station.fingers:
            q = held_samples(station.scenario, recording, f"{finger.name}.sampled_joint_angles").mean(axis=1)
            estimated, true = (
                np.array([getattr(row, column) for row in rows if row.finger == finger.name]).reshape(q.shape)
                for column in ("estimated_nm", "true_nm")
            )
            stiffness = finger.finger.stiffness
            seeming, bend = (angles.reshape(-1, 4, 3).sum(axis=-1) for angles in (estimated / stiffness, q))
            np.testing.assert_allclose(seeming, 0.1 * bend, atol=0.003 * np.abs(bend).max())
            np.testing.assert_allclose(estimated[:, 0], 0.1 * stiffness[0] * q[:, 0], rtol=0.02)
            np.testing.assert_array_equal(true, 0)


def test_an_estimator_of_the_users_has_its_name_and_its_own_errors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that takes every finger for straight: its tip is off by all that the finger bends."""
    (tmp_path / "straight_estimator.py").write_text(STRAIGHT)
    monkeypatch.syspath_prepend(tmp_path)
    station, recording = run_of("free_bending", "estimator.type=straight_estimator:Straight")
    poses, forces = (table("run", station, recording) for table in (recorded_pose_table, recorded_force_table))
    assert {row.estimator for row in (*poses, *forces)} == {"straight_estimator:Straight"}
    assert {row.sections for row in (*poses, *forces)} == {4}
    for finger in station.fingers:
        q = held_samples(station.scenario, recording, f"{finger.name}.sampled_joint_angles")
        tip = forward_kinematics(q, finger.finger.segment_length).tip
        expected = 1e3 * np.abs(tip - finger.finger.length).mean(axis=1)
        np.testing.assert_allclose([row.tip_error_mm for row in poses if row.finger == finger.name], expected)
        assert max(expected) > 10
