"""soft-gripper hardware as a user calls it, on recordings that an independent script made up."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from command_line import soft_gripper
from synthetic_hardware import (
    ARM,
    BEAM,
    SEGMENT,
    TRIALS,
    arm_bodies,
    arm_state,
    beam_motion,
    segment_motion,
    write_arm,
    write_beam,
    write_segment,
)

from soft_gripper.commands.hardware import hardware as hardware_command
from soft_gripper.evaluation.hardware.experiments import SEGMENT as SEGMENT_EXPERIMENT
from soft_gripper.evaluation.hardware.experiments import Experiment
from soft_gripper.evaluation.hardware.hardware_figure import hardware_figure as draw
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
    free = ("youngs_modulus", "pressure_law", "creep.share", "fill_time", "mounting_x", "mounting_z")
    monkeypatch.setattr(hardware_command, "SEGMENT", replace(SEGMENT_EXPERIMENT, free=free))
    figures = []
    monkeypatch.setattr(hardware_command, "hardware_figure", lambda *given: figures.append(draw(*given)) or figures[0])
    monkeypatch.setattr(Experiment, "finger_file", property(lambda self: tmp_path / f"{self.description}.urdf"))
    for name in ("clamped_beam", "pneumatic_segment"):
        text = (DIRECTORY / f"recordings/{name}.urdf").read_text()
        (tmp_path / f"{name}.urdf").write_text(text.replace('segments="12"', 'segments="5"'))
    write_beam(tmp_path / "data/clamped_beam", 1.7)
    write_segment(tmp_path / "data/pneumatic_segment", 2.9)
    write_arm(tmp_path / "data/two_segment_arm", 4.5)
    out = tmp_path / "out"
    outcome = soft_gripper("hardware", "--data", tmp_path / "data", "--out", out, "--jobs", 1)
    claims = {row["text"]: row for row in rows_of(out / "claims.csv")}
    failed = [text for text, row in claims.items() if row["holds"] != "True"]
    assert failed == []
    assert outcome.code == 0
    beam = read_finger(out / "clamped_beam.urdf")
    assert beam.base.youngs_modulus == pytest.approx(BEAM.youngs_modulus, rel=0.02)
    assert beam.relaxation_time == pytest.approx(BEAM.relaxation_time, rel=0.1)
    assert sum(branch.share for branch in beam.creep) == pytest.approx(sum(dict(BEAM.creep)), abs=0.04)
    panels = figures[0].axes
    assert [len(axes.lines) for axes in panels] == [2 * 3, 2 * 5, 3]
    heaviest, pressed, tip = (axes.lines[i].get_ydata() for axes, i in zip(panels, (4, 4, 0), strict=True))
    place, heading = beam_motion(BEAM, 0.102, np.arange(0, 1.7, 0.01), BEAM.released + 0.26)
    middle = np.mean([0.013j, 0.001 + 0.002j, -0.002 - 0.012j])
    away = np.abs(place + (np.exp(1j * heading) - 1) * middle - 0.1)
    np.testing.assert_allclose(heaviest, 1e3 * away, atol=0.1)
    _, turn = segment_motion(SEGMENT, 45e3, np.arange(0, 2.9, 0.01), SEGMENT.opens + 0.28)
    np.testing.assert_allclose(pressed, np.degrees(turn), atol=0.3)
    _, bends, lengths = arm_state(ARM, "trial_2", np.arange(0, 4.5, 0.01))
    across = 1e3 * arm_bodies(ARM, bends, lengths)[0][:, 1].imag
    assert (tip.min(), tip.max()) == pytest.approx((across.min(), across.max()), abs=3.0)
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
