"""report.html: the whole evaluation in one file that needs no network."""

import base64
import gzip
from collections.abc import Sequence
from dataclasses import astuple, dataclass, field
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.extras.paper.claims import Claim, verdict
from soft_gripper.extras.paper.contact_table import ContactRow, contact_summary
from soft_gripper.extras.paper.differences import PaperDifference, TipErrors
from soft_gripper.extras.paper.pose_rows import estimator_rows, mean_errors
from soft_gripper.files.output import atomic_file
from soft_gripper.pictures.style import STYLE, estimator_style, section_style
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.steps import PhaseRow
from soft_gripper.scenario.scenario_file import load_scenario

TEMPLATE = Path(__file__).parent / "report_template.html"


@dataclass(frozen=True)
class Evaluation:
    """The tables of all runs, and the results derived from them."""

    poses: list[PoseRow]  # of all estimators
    forces: list[ForceRow]
    claims: list[Claim]
    contacts: list[ContactRow] = field(default_factory=list)
    differences: list[PaperDifference] = field(default_factory=list)
    phases: list[PhaseRow] = field(default_factory=list)  # of the task
    outcome: str = ""  # of the task, in words


def write_report(
    out: Path, scenarios: Sequence[str], evaluation: Evaluation, figures: dict[str, str], task: Path
) -> None:
    """Writes `out`/report.html from the tables and from the files of the finished runs in `out`.

    Args:
        out: the folder of the evaluation.
        scenarios: those with a picture and an animation.
        evaluation: the tables.
        figures: caption of each figure, by its name, which its SVG in `out` and its place in the template have too.
        task: the picture of the task, a PNG.
    """
    style = "holds" if all(claim.holds for claim in evaluation.claims) else "fails"
    parts = {
        "verdict": f'<p class="{style}">{verdict(evaluation.claims).capitalize()}.</p>',
        "claims": "\n".join(map(_claim, evaluation.claims)),
        "differences": "\n".join(map(_difference, evaluation.differences)),
        "scenes": "\n".join(_scene(out / name) for name in scenarios),
        "errors": "\n".join(_errors(title(name), name, estimator_rows(evaluation.poses, "arcs")) for name in scenarios),
        "estimator_errors": "\n".join(_estimators(name, evaluation.poses) for name in scenarios),
        "contacts": "\n".join(_contact(*astuple(row)) for row in contact_summary(evaluation.contacts)),
        "outcome": escape(evaluation.outcome),
        "phases": "\n".join(map(_phase, evaluation.phases)),
        "task": _figure(task, "png", "The path of the box, the gripper at the end of every phase, and the signals."),
        **{name: _figure(out / f"{name}.svg", "svg+xml", caption) for name, caption in figures.items()},
    }
    page = Template(TEMPLATE.read_text(encoding="utf-8")).substitute(parts)
    with atomic_file(out / "report.html") as partial:
        partial.write_text(page, encoding="utf-8")


def title(scenario: str) -> str:
    """A scenario's name as a heading."""
    return scenario.replace("_", " ").capitalize()


def _claim(claim: Claim) -> str:
    verdict = '<td class="text holds">holds</td>' if claim.holds else '<td class="text fails">fails</td>'
    cells = f'<td>{escape(claim.text)}</td><td class="text">{escape(claim.source)}</td>{verdict}'
    return f'<tr class="claim">{cells}<td class="text">{escape(claim.number)}</td></tr>'


def _difference(row: PaperDifference) -> str:
    cells = "".join(f'<td class="text">{escape(text)}</td>' for text in astuple(row))
    return f'<tr class="difference">{cells}</tr>'


def _scene(folder: Path) -> str:
    name = escape(folder.name)
    heading = escape(title(folder.name))
    picture = base64.b64encode((folder / "scene.png").read_bytes()).decode()
    animation = base64.b64encode(gzip.compress((folder / "animation.html").read_bytes(), mtime=0)).decode()
    return (
        f'<div class="scene"><div class="stage"><img alt="{heading}" src="data:image/png;base64,{picture}"></div>'
        f'<div class="caption"><span><b>{heading}</b><br>{escape(load_scenario(folder.name).description)}</span>'
        f'<button data-animation="animation-{name}">3-D animation</button></div>'
        f'<script type="application/gzip" id="animation-{name}">{animation}</script></div>'
    )


def _errors(heading: str, scenario: str, poses: Sequence[PoseRow]) -> str:
    means = [*mean_errors(poses, scenario, "pose_error_mm"), *mean_errors(poses, scenario, "tip_error_mm")]
    return _row(heading, *(f"{error:.2f}" for error in means))


def _estimators(scenario: str, poses: Sequence[PoseRow]) -> str:
    """A row for every estimator; the scenario is named in the first."""
    names = list(dict.fromkeys(row.estimator for row in poses))
    headings = [f"{title(scenario)}: {names[0]}", *names[1:]]
    rows = zip(headings, names, strict=True)
    return "\n".join(_errors(heading, scenario, estimator_rows(poses, name)) for heading, name in rows)


def _contact(scenario: str, links: int, length: float, sign_changes: int) -> str:
    return _row(title(scenario), links, f"{length:.0f}", "yes" if sign_changes else "no")


def _phase(row: PhaseRow) -> str:
    begin, duration = f"{row.began_s:.2f}", f"{row.lasted_s:.2f}"
    final_values = (row.opening_mm, row.torque_mnm, row.pressure_kpa)
    return _row(row.phase, begin, duration, *(f"{value:z.1f}" for value in final_values))


def _row(*cells: Any) -> str:
    return "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in cells) + "</tr>"


def _figure(file: Path, kind: str, caption: str) -> str:
    picture = base64.b64encode(file.read_bytes()).decode()
    image = f'<img alt="{escape(caption)}" src="data:image/{kind};base64,{picture}">'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"


PAPER = 2.0  # mm, the paper's mean pose error in contact with four sensors
MIN_ERROR, MAX_ERROR = 1e-3, 10.0  # mm; smaller errors are drawn here


AS_ARCS = "constant_curvature"  # has the same arcs, and other torques


def estimators_figure(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> Figure:
    """Mean pose error against the number of sensors: a line per estimator, a panel per scenario, up to five.

    AS_ARCS has no line: it would hide another one.
    """
    names = dict.fromkeys(row.estimator for row in rows)
    counts = sorted({row.sections for row in rows})
    estimators = [name for name in names if name != AS_ARCS]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 5.2), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True).flat
        for axes, scenario in zip(panels, scenarios, strict=False):
            for place, name in enumerate(estimators):
                errors = np.maximum(mean_errors(estimator_rows(rows, name), scenario, "pose_error_mm"), MIN_ERROR)
                axes.plot(counts, errors, clip_on=False, zorder=3, **estimator_style(place, name))
            axes.axhline(PAPER, color="0.45", lw=1, ls=(0, (4, 3)))
            axes.set(
                title=scenario.replace("_", " ").capitalize(), yscale="log", ylim=(MIN_ERROR, MAX_ERROR), xticks=counts
            )
            axes.tick_params(labelbottom=True)
        axes = figure.axes[0]
        axes.yaxis.set_major_formatter("{x:g}")
        axes.text(counts[-1], 1.15 * PAPER, "paper, four sensors", ha="right", fontsize=8, color="0.35")
        _legend(figure, len(scenarios))
    return figure


def _legend(figure: Figure, lines: int) -> None:
    """The legend, in the free panel, and the labels of the axes."""
    for axes in figure.axes[lines:]:
        axes.set_axis_off()
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.axes[-1].legend(handles, labels, title="estimator", loc="center", frameon=False, fontsize=10)
    for axes in figure.axes[::3]:
        axes.set_ylabel("mean pose error [mm]")
    for axes in figure.axes[lines - 3 : lines]:
        axes.set_xlabel("sensors per side")


TITLES = {
    "middles": "joints in the middles\nof the segments (here)",
    "starts": "joints where\nthe segments begin",
    "noisy": "joints in the middles,\nreadings with 0.1 % noise",
}


def difference_figure(bend: Array, errors: TipErrors) -> Figure:
    """Fingertip error in free bending against the bend angle, on one scale, for three chains, 1 to 4 sensors.

    `bend` are the bend angles of the steps of `errors`, rad; of steps with equal bend the first is drawn.
    """
    degrees, first_rows = np.unique(np.degrees(bend).round(1), return_index=True)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        panels = figure.subplots(1, 3, sharex=True, sharey=True)
        for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
            for sections, error in zip(errors.sections, 1e3 * getattr(errors, name)[:, first_rows], strict=True):
                axes.plot(degrees, error, **section_style(sections))
            axes.set(title=title, xlabel="bend angle [degrees]")
        panels[0].set(ylabel="fingertip error [mm]", ylim=(0, None))
        panels[0].legend(title="sensors per side", frameon=False)
    return figure
