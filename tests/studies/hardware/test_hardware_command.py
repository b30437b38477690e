"""python -m studies hardware as a user calls it, on recordings that an independent script made up."""

import re
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import MagicMock

import pytest
from command_line import Outcome
from csv_rows import csv_rows
from here_executor import HereExecutor
from study_line import study_line
from synthetic_hardware import SEGMENT, write_arm, write_beam, write_segment

from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.replay import held_out
from soft_gripper.extras.paper.claims import Claim
from soft_gripper.models import DIRECTORY
from studies.commands import hardware as hardware_command
from studies.hardware import published as experiments

PUMPED = replace(SEGMENT, open_for=1.2)  # the segment, its valve open for a shorter time
BEAM_LASTS, SEGMENT_LASTS, ARM_LASTS = 1.7, 3.6, 4.5  # s; of the segment long enough for what recovers to be seen
FREE = ("youngs_modulus", "pressure_law", "fill_time", "swelling", "mounting_x", "mounting_z")  # of the segment
ROWS = {f"{name} {count}": (name, count) for name in ("arcs", "gaussian") for count in (1, 2)}  # of the claims


@pytest.mark.parametrize("holds", [True, False])
def test_a_claim_that_fails_is_the_exit_code(tmp_path, monkeypatch, holds):
    for name in ("published_recordings", "replay", "fit_remarks", "hardware_figure", "save_figure"):
        monkeypatch.setattr(hardware_command, name, MagicMock())
    for name in (
        "open_executor",
        "identify_published",
        "print_replay",
        "print_identified",
        "write_fitted",
        "write_csv",
    ):
        monkeypatch.setattr(hardware_command, name, MagicMock())
    claims = [Claim("ours", "one", True, "1"), Claim("ours", "other", holds, "2")]
    monkeypatch.setattr(hardware_command, "hardware_claims", lambda *_: claims)
    assert study_line("hardware", "--out", tmp_path / "out").code == (0 if holds else 1)


@dataclass(frozen=True)
class Run:
    """What the command left."""

    out: Path
    outcome: Outcome
    setup: Setup  # of the segment


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The whole command; faster than on hardware: chains of few segments, fewer keys, two estimators, one process."""
    folder = tmp_path_factory.mktemp("hardware")
    data, setups = folder / "data", []
    write_beam(data / "clamped_beam", BEAM_LASTS)
    write_segment(data / "pneumatic_segment", SEGMENT_LASTS, PUMPED)
    write_arm(data / "two_segment_arm", ARM_LASTS)
    for name in ("clamped_beam", "pneumatic_segment"):
        write_guess(folder / f"{name}.urdf")

    def draw(*found):
        setups.append(found[1].model.setup)
        return experiments.hardware_figure(*found)

    with pytest.MonkeyPatch.context() as patch:
        faster = replace(experiments.SEGMENT, free=FREE, tested=("15kPa", "35kPa"))
        patch.setattr(experiments, "SEGMENT", faster)
        patch.setattr(hardware_command, "SEGMENT", faster)
        patch.setattr(hardware_command, "open_executor", lambda *_: nullcontext(HereExecutor()))
        patch.setattr(hardware_command, "hardware_figure", draw)
        patch.setattr(held_out, "estimator_rows", lambda *_: ROWS)
        patch.setattr(experiments.Experiment, "finger_file", property(lambda self: folder / f"{self.description}.urdf"))
        outcome = study_line("hardware", "--data", data, "--out", folder / "out")
    assert outcome.code == 0, outcome.out[-3000:]
    return Run(folder / "out", outcome, *setups)


def write_guess(file):
    """The shipped first guess, with fewer segments; of the segment with what is not fitted here as in truth."""
    text = (DIRECTORY / "recordings" / file.name).read_text()
    shares, times = (" ".join(map(str, part)) for part in zip(*PUMPED.creep, strict=True))
    text = text.replace('<creep share="0.1" time="1.5"/>', f'<creep share="{shares}" time="{times}"/>')
    text = text.replace('relaxation_time="0.004"', f'relaxation_time="{PUMPED.relaxation_time}"')
    text = text.replace('length="0.09"', f'length="{PUMPED.length}"').replace(
        'density="1070"', f'density="{PUMPED.density}"'
    )
    file.write_text(re.sub('segments="[0-9]+"', 'segments="4"', text))


@pytest.mark.published
def test_every_claim_holds(run):
    claims = csv_rows(run.out / "claims.csv")
    assert [row["text"] for row in claims if row["holds"] != "True"] == []
    assert (len(claims), run.outcome.code) == (25, 0)
    assert run.outcome.out.count(" holds: ") == 25
