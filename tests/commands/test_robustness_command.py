"""soft-gripper evaluate --robustness: what it runs, prints and ends with."""

from itertools import product
from pathlib import Path

import pytest
from command_line import soft_gripper

from soft_gripper.evaluation.paper.claims import Claim
from soft_gripper.evaluation.report.evaluate import SCENARIOS
from soft_gripper.evaluation.report.page import Evaluation
from soft_gripper.evaluation.robustness.claims import Robustness
from soft_gripper.evaluation.robustness.jobs import NOISE_JOBS
from soft_gripper.evaluation.robustness.table import PlantRow, RobustnessRow
from soft_gripper.runs.scores.poses import PoseRow

SECTIONS = (1, 2, 3, 4)
POSES = [
    PoseRow(scenario, "finger", name, "as simulated", n, 50.0, 0.0, 1.0 / n, 2.0 / n)
    for name, scenario, n in product(("arcs", "gaussian"), SCENARIOS, SECTIONS)
]
HOLDS = Claim("ours", "two sensors are within 1 mm", True, "0.52 mm")
FAILS = Claim("ours", "two sensors are better than four", False, "1.04 times")
ERRING = [
    RobustnessRow(s, name, nominal, 1.0, n, 1.0 / n, 2.0 / n, 3.0, 0.9, 7)
    for s, name, nominal, n in product(SCENARIOS, ("arcs", "gaussian"), ("as simulated", "wrong"), SECTIONS)
]
OTHER = [PlantRow("rubber", s, "arcs", n, 4.0 / n, 8.0 / n, 9.0, 5.0, 0.9, 7) for s, n in product(SCENARIOS, SECTIONS)]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> dict[str, list[object]]:
    """What `--robustness` is about to run; the jobs of box_grasp are finished."""
    called: dict[str, list[object]] = {}
    where = "soft_gripper.commands.evaluate."
    monkeypatch.setattr(where + "run_robustness", lambda jobs, *_: called.update(jobs=list(jobs)))
    left = [job for job in NOISE_JOBS if not job.startswith("box_grasp")]
    monkeypatch.setattr(where + "unfinished_robustness", lambda out, seeds, _: left if seeds == 7 else list(NOISE_JOBS))
    monkeypatch.setattr(where + "unfinished", lambda out: [])
    monkeypatch.setattr(where + "run_scenarios", lambda *_: None)
    monkeypatch.setattr(where + "summarize", lambda _: Evaluation(POSES, [], [HOLDS]))
    return called


@pytest.mark.parametrize(("claim", "code"), [(HOLDS, 0), (FAILS, 1)])
def test_robustness_is_run_and_printed(
    claim: Claim, code: int, run: dict[str, list[object]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = Robustness(ERRING, OTHER, [claim])
    monkeypatch.setattr("soft_gripper.commands.evaluate.summarize_robustness", lambda _: found)
    outcome = soft_gripper("evaluate", "--out", tmp_path, "--robustness", "--resume", "--seeds", "7")
    assert outcome.code == code
    assert run["jobs"] == [job for job in NOISE_JOBS if not job.startswith("box_grasp")]
    lines = [line.split() for line in outcome.out.splitlines()]
    assert ["gaussian", "1.00", "0.50", "0.33", "0.25", "2.00", "1.00", "0.67", "0.50"] in lines
    assert ["rubber,", "arcs", "4.00", "2.00", "1.33", "1.00", "8.00", "4.00", "2.67", "2.00"] in lines
    assert claim.text in outcome.out


def test_without_the_option_nothing_of_it_is_run(run: dict[str, list[object]], tmp_path: Path) -> None:
    assert soft_gripper("evaluate", "--out", tmp_path).code == 0
    assert run == {}


@pytest.mark.parametrize("seeds", ["0", "many"])
def test_seeds_are_a_number(seeds: str, tmp_path: Path) -> None:
    refused = soft_gripper("evaluate", "--out", tmp_path, "--seeds", seeds)
    assert refused.code == 2
    assert "give a whole number from 1" in refused.err
