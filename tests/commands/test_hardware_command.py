"""soft-gripper hardware as a user calls it, on recordings that an independent script made up."""

import csv
from contextlib import nullcontext

import numpy as np
import pytest
from command_line import soft_gripper
from here_executor import HereExecutor
from synthetic_hardware import BEAM, SEGMENT, TRIALS, write_arm, write_beam, write_segment

from soft_gripper.commands.hardware import hardware as hardware_command
from soft_gripper.evaluation.hardware.experiments import Experiment
from soft_gripper.evaluation.identify.finger_file import read_finger
from soft_gripper.models import DIRECTORY


def test_a_missing_folder_is_one_line(tmp_path):
    outcome = soft_gripper("hardware", "--data", tmp_path / "nowhere", "--out", tmp_path / "out")
    assert outcome.code == 2
    assert "there is no such folder" in outcome.err
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_made_up_hardware_is_identified_and_replayed(tmp_path, monkeypatch):
    """All of it, with chains of few segments: fingers, tables, claims and the figure."""
    monkeypatch.setattr(hardware_command, "chosen_executor", lambda *_: nullcontext(HereExecutor()))
    monkeypatch.setattr(Experiment, "finger_file", property(lambda self: tmp_path / f"{self.description}.urdf"))
    for name in ("clamped_beam", "pneumatic_segment"):
        text = (DIRECTORY / f"recordings/{name}.urdf").read_text()
        (tmp_path / f"{name}.urdf").write_text(text.replace('segments="12"', 'segments="5"'))
    write_beam(tmp_path / "data/clamped_beam", 1.6)
    write_segment(tmp_path / "data/pneumatic_segment")
    write_arm(tmp_path / "data/two_segment_arm", 6.0)
    out = tmp_path / "out"
    outcome = soft_gripper("hardware", "--data", tmp_path / "data", "--out", out)
    claims = {row["text"]: row for row in rows_of(out / "claims.csv")}
    failed = [text for text, row in claims.items() if row["holds"] != "True"]
    assert failed == []
    assert outcome.code == 0
    beam = read_finger(out / "clamped_beam.urdf")
    assert beam.base.youngs_modulus == pytest.approx(BEAM.youngs_modulus, rel=0.02)
    assert beam.relaxation_time == pytest.approx(BEAM.relaxation_time, rel=0.1)
    assert sum(branch.share for branch in beam.creep) == pytest.approx(sum(dict(BEAM.creep)), abs=0.04)
    segment = read_finger(out / "pneumatic_segment.urdf")
    ratio = [segment.softening(p) / segment.base.youngs_modulus for p in (1e4, 2.5e4, 4.5e4)]
    truth = [SEGMENT.gain(p) / SEGMENT.youngs_modulus for p in (1e4, 2.5e4, 4.5e4)]
    np.testing.assert_allclose(ratio, truth, rtol=0.1)
    names = {path.name for path in out.iterdir()}
    tables = {f"{name}.csv" for name in ("clamped_beam", "pneumatic_segment", "two_segment_arm", "claims")}
    assert names == tables | {"clamped_beam.urdf", "pneumatic_segment.urdf", "hardware.png", "hardware.svg"}
    assert {row["recording"] for row in rows_of(out / "two_segment_arm.csv")} == {*TRIALS, "all"}


def rows_of(file):
    with file.open() as text:
        return list(csv.DictReader(text))
