"""report.html: the whole evaluation in one file that needs no network."""

import base64
import gzip
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

import numpy as np

from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.evaluation.paper.claims import Claim, verdict
from soft_gripper.evaluation.paper.pose_table import PoseRow
from soft_gripper.files import atomic_file

TEMPLATE = Path(__file__).with_name("report_template.html")


def write_report(
    out: Path, scenarios: Sequence[str], poses: Sequence[PoseRow], claims: Sequence[Claim], figures: dict[str, str]
) -> None:
    """Writes `out`/report.html from the files of the finished scenarios in `out`.

    Args:
        figures: name of each figure (its SVG lies in `out`) and its caption.
    """
    parts = {
        "verdict": _verdict(claims),
        "claims": "\n".join(map(_claim, claims)),
        "scenes": "\n".join(_scene(out / name) for name in scenarios),
        "errors": "\n".join(_errors(name, poses) for name in scenarios),
        "figures": "\n".join(_figure(out / f"{name}.svg", caption) for name, caption in figures.items()),
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
    cells = f'<td>{escape(claim.text)}</td><td class="text">{claim.source}</td>{verdict}'
    return f'<tr class="claim">{cells}<td class="text">{escape(claim.number)}</td></tr>'


def _scene(folder: Path) -> str:
    name = folder.name
    picture = base64.b64encode((folder / "scene.png").read_bytes()).decode()
    replay = base64.b64encode(gzip.compress((folder / "replay.html").read_bytes(), mtime=0)).decode()
    return (
        f'<div class="scene"><div class="stage"><img alt="{title(name)}" src="data:image/png;base64,{picture}"></div>'
        f'<div class="caption"><span><b>{title(name)}</b><br>{escape(load_scenario(name).description)}</span>'
        f'<button data-replay="replay-{name}">3-D replay</button></div>'
        f'<script type="application/gzip" id="replay-{name}">{replay}</script></div>'
    )


def _errors(scenario: str, poses: Sequence[PoseRow]) -> str:
    means = [
        np.mean([getattr(row, error) for row in poses if (row.scenario, row.sections) == (scenario, sections)])
        for error in ("pose_error_mm", "tip_error_mm")
        for sections in sorted({row.sections for row in poses})
    ]
    return f"<tr><td>{title(scenario)}</td>" + "".join(f"<td>{mean:.2f}</td>" for mean in means) + "</tr>"


def _figure(svg: Path, caption: str) -> str:
    picture = base64.b64encode(svg.read_bytes()).decode()
    image = f'<img alt="{escape(caption)}" src="data:image/svg+xml;base64,{picture}">'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"
