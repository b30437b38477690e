"""report.html: the whole evaluation in one file that needs no network."""

import base64
import gzip
from collections.abc import Sequence
from dataclasses import astuple, dataclass, field
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from soft_gripper.evaluation.paper.claims import Claim, verdict
from soft_gripper.evaluation.paper.contact_table import ContactRow, contact_summary
from soft_gripper.evaluation.paper.differences import Difference
from soft_gripper.evaluation.paper.forces import ForceRow
from soft_gripper.evaluation.pid_regimes import RegimeRow
from soft_gripper.files.output import atomic_file
from soft_gripper.runs.scores.phases import PhaseRow
from soft_gripper.runs.scores.poses import PoseRow, mean_errors, of_estimator
from soft_gripper.scenario.scenario_file import load_scenario

TEMPLATE = Path(__file__).parent / "report_template.html"


@dataclass(frozen=True)
class Evaluation:
    """The tables of all runs, and what follows from them."""

    poses: list[PoseRow]  # of all estimators
    forces: list[ForceRow]
    claims: list[Claim]
    contacts: list[ContactRow] = field(default_factory=list)
    differences: list[Difference] = field(default_factory=list)
    regimes: list[RegimeRow] = field(default_factory=list)
    phases: list[PhaseRow] = field(default_factory=list)  # of the task
    outcome: str = ""  # of the task, in words


def write_report(out: Path, scenarios: Sequence[str], found: Evaluation, figures: dict[str, str], task: Path) -> None:
    """Writes `out`/report.html from the tables and from the files of the finished runs in `out`.

    Args:
        out: the folder of the evaluation.
        scenarios: those with a picture and a replay.
        found: the tables.
        figures: name of each figure (its SVG lies in `out`, its place in the template has its name) and its caption.
        task: the picture of the task, a PNG.
    """
    parts = {
        "verdict": _verdict(found.claims),
        "claims": "\n".join(map(_claim, found.claims)),
        "differences": "\n".join(map(_difference, found.differences)),
        "scenes": "\n".join(_scene(out / name) for name in scenarios),
        "errors": "\n".join(_errors(title(name), name, of_estimator(found.poses, "arcs")) for name in scenarios),
        "estimator_errors": "\n".join(_estimators(name, found.poses) for name in scenarios),
        "contacts": "\n".join(_contact(*astuple(row)) for row in contact_summary(found.contacts)),
        "regimes": "\n".join(map(_regime, found.regimes)),
        "outcome": escape(found.outcome),
        "phases": "\n".join(map(_phase, found.phases)),
        "task": _figure(task, "png", "The path of the box, the gripper at the end of every phase, and the signals."),
        **{name: _figure(out / f"{name}.svg", "svg+xml", caption) for name, caption in figures.items()},
    }
    page = Template(TEMPLATE.read_text(encoding="utf-8")).substitute(parts)
    with atomic_file(out / "report.html") as partial:
        partial.write_text(page, encoding="utf-8")


def title(scenario: str) -> str:
    """A scenario's name as a heading."""
    return scenario.replace("_", " ").capitalize()


def _verdict(claims: Sequence[Claim]) -> str:
    style = "holds" if all(claim.holds for claim in claims) else "fails"
    return f'<p class="{style}">{verdict(claims).capitalize()}.</p>'


def _claim(claim: Claim) -> str:
    verdict = '<td class="text holds">holds</td>' if claim.holds else '<td class="text fails">fails</td>'
    cells = f'<td>{escape(claim.text)}</td><td class="text">{escape(claim.source)}</td>{verdict}'
    return f'<tr class="claim">{cells}<td class="text">{escape(claim.number)}</td></tr>'


def _difference(row: Difference) -> str:
    cells = "".join(f'<td class="text">{escape(text)}</td>' for text in astuple(row))
    return f'<tr class="difference">{cells}</tr>'


def _scene(folder: Path) -> str:
    name, heading = escape(folder.name), escape(title(folder.name))
    picture = base64.b64encode((folder / "scene.png").read_bytes()).decode()
    replay = base64.b64encode(gzip.compress((folder / "replay.html").read_bytes(), mtime=0)).decode()
    return (
        f'<div class="scene"><div class="stage"><img alt="{heading}" src="data:image/png;base64,{picture}"></div>'
        f'<div class="caption"><span><b>{heading}</b><br>{escape(load_scenario(folder.name).description)}</span>'
        f'<button data-replay="replay-{name}">3-D replay</button></div>'
        f'<script type="application/gzip" id="replay-{name}">{replay}</script></div>'
    )


def _errors(heading: str, scenario: str, poses: Sequence[PoseRow]) -> str:
    means = [*mean_errors(poses, scenario, "pose_error_mm"), *mean_errors(poses, scenario, "tip_error_mm")]
    return _row(heading, *(f"{mean:.2f}" for mean in means))


def _estimators(scenario: str, poses: Sequence[PoseRow]) -> str:
    """A row for every estimator; the scenario is named in the first."""
    names = list(dict.fromkeys(row.estimator for row in poses))
    headings = [f"{title(scenario)}: {names[0]}", *names[1:]]
    rows = zip(headings, names, strict=True)
    return "\n".join(_errors(heading, scenario, of_estimator(poses, name)) for heading, name in rows)


def _contact(scenario: str, links: int, length: float, sign_changes: int) -> str:
    return _row(title(scenario), links, f"{length:.0f}", "yes" if sign_changes else "no")


def _regime(row: RegimeRow) -> str:
    gains = (f"{gain:.5g}" for gain in (row.kp_kpa, row.ki_kpa, row.kd_kpa))
    follows = (f"{row.from_mm:.0f} to {row.to_mm:.0f}", f"{row.overshoot_percent:.0f}", row.crossings)
    return _row(row.regime.capitalize(), *gains, *follows, f"{row.settling_s:.2f}")


def _phase(row: PhaseRow) -> str:
    began, lasted = f"{row.began_s:.2f}", f"{row.lasted_s:.2f}"
    at_end = (row.opening_mm, row.torque_mnm, row.pressure_kpa)
    return _row(row.phase, began, lasted, *(f"{value:z.1f}" for value in at_end))


def _row(*cells: Any) -> str:
    return "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in cells) + "</tr>"


def _figure(file: Path, kind: str, caption: str) -> str:
    picture = base64.b64encode(file.read_bytes()).decode()
    image = f'<img alt="{escape(caption)}" src="data:image/{kind};base64,{picture}">'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"
