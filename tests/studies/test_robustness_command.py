"""python -m studies robustness: what it runs, prints and ends with."""

from itertools import product
from pathlib import Path

import pytest
from refusals import refusal
from study_line import study_line

from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.scenario_run import SCENARIOS
from studies.commands import STUDIES
from studies.commands import robustness as command
from studies.robustness.jobs import FOLDER
from studies.robustness.rows import PlantRow, RobustnessRow

SECTIONS = (1, 2, 3, 4)
HOLDS = Claim("ours", "two sensors are within 1 mm", True, "0.52 mm")
FAILS = Claim("ours", "two sensors are better than four", False, "1.04 times")
ERRING = [
    RobustnessRow(s, name, nominal, 1.0, n, 1.0 / n, 2.0 / n, 3.0, 0.9, 7)
    for s, name, nominal, n in product(SCENARIOS, ("arcs", "gaussian"), ("as simulated", "wrong"), SECTIONS)
]
OTHER = [PlantRow("rubber", s, "arcs", n, 4.0 / n, 8.0 / n, 9.0, 5.0, 0.9, 7) for s, n in product(SCENARIOS, SECTIONS)]


@pytest.mark.parametrize(("claim", "code"), [(HOLDS, 0), (FAILS, 1)])
def test_is_run_and_printed(claim: Claim, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run_robustness(out: Path, seeds: int, *others: object) -> tuple[list[RobustnessRow], list[PlantRow]]:
        (out / FOLDER).mkdir()
        asked.append((out, seeds, others[-1]))
        return ERRING, OTHER

    asked: list[tuple[Path, int, object]] = []
    monkeypatch.setattr(command, "run_robustness", run_robustness)
    monkeypatch.setattr(command, "is_finished", lambda *_: True)
    monkeypatch.setattr(command, "robustness_claims", lambda rows, plants: [claim])
    outcome = study_line("robustness", "--out", tmp_path, "--resume", "--seeds", "7")
    assert outcome.code == code
    assert asked == [(tmp_path, 7, True)]
    assert (tmp_path / FOLDER / "robustness.png").stat().st_size > 10_000
    lines = [line.split() for line in outcome.out.splitlines()]
    assert ["gaussian", "1.00", "0.50", "0.33", "0.25", "2.00", "1.00", "0.67", "0.50"] in lines
    assert ["rubber,", "arcs", "4.00", "2.00", "1.33", "1.00", "8.00", "4.00", "2.67", "2.00"] in lines
    assert claim.text in outcome.out


def test_without_an_evaluation_it_says_how_to_make_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert f"soft-gripper evaluate --out {tmp_path}" in refusal("robustness", "--out", tmp_path, program=STUDIES)
