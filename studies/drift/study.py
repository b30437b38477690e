"""The study of drift: its jobs, table, figure and claims."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.extras.paper.claims import Claim
from soft_gripper.files.row_table import cells, columns, row_from_cells, write_csv
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.study import StudyTables
from studies.drift.hour import MINUTES, POLICIES, DriftRow, drift_rows

TABLE, ABOUT, SUMMARY, FIGURE = "drift_parts.csv", "drift_parts.txt", "drift.csv", "drift"
COVERED = 90.0, 99.0  # %, at the last minute, under each policy
LARGEST_TIP = 2.9  # % of the length, under the best policy


@dataclass(frozen=True)
class PolicyRow:
    """All parts of the study under one policy, in the SPAN before `minute`."""

    policy: str
    minute: int
    pose_mm: Annotated[float, ".2f"]  # mean
    tip_mm: Annotated[float, ".2f"]  # mean
    tip_percent: Annotated[float, ".2f"]  # of the length
    shape_covered_percent: Annotated[float, ".1f"]
    force_error_n: Annotated[float, ".3f"]  # median of each part, in the mean
    force_width_n: Annotated[float, ".3f"]  # likewise
    force_covered_percent: Annotated[float, ".1f"]  # of what is stated
    force_stated_percent: Annotated[float, ".1f"]
    samples: int


def run_drift(
    folder: Path, parts: int, seed: int, executor: Executor, report: Callable[[int], Any], resume: bool = False
) -> list[PolicyRow]:
    """Runs the study, writes its tables and figure, and returns the rows.

    Args:
        folder: of the files.
        parts: sets of grasps and sensors, each an hour under every policy.
        seed: of all that is random.
        executor: makes the calls.
        report: called with the number of each part as it ends, or at once if its rows exist.
        resume: keep existing rows.

    Raises:
        InputError: if the study to be resumed is another one.
    """
    tables = StudyTables(folder, ABOUT, {TABLE: columns(DriftRow)}, 3)
    tables.begin(f"seed: {seed}\nparts: {parts}\n", resume)

    def keep(part: int, rows: list[DriftRow]) -> None:
        for row in rows:
            tables.add(cells(row))

    def keys(part: int) -> list[tuple[str, ...]]:
        return [(str(part), policy, str(minute)) for policy in POLICIES for minute in MINUTES]

    jobs = {part: (part, seed) for part in range(parts)}
    tables.run(executor, drift_rows, jobs, keep, ended=report, keys=keys)
    tables.finish(key for part in jobs for key in keys(part))
    rows = summary([row_from_cells(row, DriftRow) for (row,) in tables.rows.values()])
    write_csv(folder / SUMMARY, rows)
    save_figure(drift_figure(rows), folder / FIGURE)
    return rows


def summary(rows: Sequence[DriftRow]) -> list[PolicyRow]:
    """All parts together, by policy and minute, in the order of the rows."""
    found = []
    for policy, minute in dict.fromkeys((row.policy, row.minute) for row in rows):
        chosen = [row for row in rows if (row.policy, row.minute) == (policy, minute)]
        samples = np.array([row.samples for row in chosen])
        stated = samples * [row.force_stated_percent for row in chosen]

        def mean(name: str, weights: Any = samples, chosen: Sequence[DriftRow] = chosen) -> float:
            return float(np.average([getattr(row, name) for row in chosen], weights=weights))

        names = [name for name in columns(PolicyRow) if name not in ("policy", "minute", "samples")]
        of_stated = ("force_error_n", "force_width_n", "force_covered_percent")
        means = {name: mean(name, stated if name in of_stated else samples) for name in names}
        found.append(PolicyRow(policy=policy, minute=minute, **means, samples=int(samples.sum())))
    return found


def drift_claims(rows: Sequence[PolicyRow]) -> list[Claim]:
    """Claims about the last minute: coverage under every policy, and the error under the best one."""
    last = [row for row in rows if row.minute == rows[-1].minute]
    best = min(last, key=lambda row: row.tip_percent)
    bounds = " to ".join(f"{share:.0f}" for share in COVERED)
    found = []
    for row in last:
        shares = row.shape_covered_percent, row.force_covered_percent
        holds = min(shares) >= COVERED[0] and max(shares) <= COVERED[1]
        text = f"minute {row.minute}, {row.policy}: 95 % bands of shape and force cover {bounds} %"
        found.append(Claim("ours", text, holds, f"{shares[0]:.1f} and {shares[1]:.1f} %"))
    text = f"minute {best.minute}, best policy: tip within {LARGEST_TIP} % of the length in the mean"
    holds = best.tip_percent <= LARGEST_TIP
    return [*found, Claim("ours", text, holds, f"{best.tip_percent:.2f} %, {best.policy}")]


_PANELS = {
    "tip_percent": "mean tip error [% of the length]",
    "shape_covered_percent": "shape: in the 95 % band [%]",
    "force_width_n": "force: width of the interval [N]",
    "force_covered_percent": "force: in the 95 % interval [%]",
}
_COLORS = "#d55e00", "#0072b2", "#009e73"


def drift_figure(rows: Sequence[PolicyRow]) -> Figure:
    """Errors and coverage over the hour, a line a policy."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.5, 5), layout="constrained")
        for axes, (name, label) in zip(figure.subplots(2, 2, sharex=True).flat, _PANELS.items(), strict=True):
            for policy, color in zip(dict.fromkeys(row.policy for row in rows), _COLORS, strict=True):
                chosen = [row for row in rows if row.policy == policy]
                values = [getattr(row, name) for row in chosen]
                axes.plot([row.minute for row in chosen], values, "o-", ms=3.5, lw=1.4, color=color, label=policy)
            axes.set_ylabel(label)
            if name.endswith("covered_percent"):
                axes.axhspan(*COVERED, color="0.9", zorder=0)
                axes.set_ylim(top=101)
            else:
                axes.set_ylim(bottom=0)
            if name == "tip_percent":
                axes.axhline(LARGEST_TIP, color="0.5", lw=0.8, ls="--")
                axes.legend(title="sensors zeroed", frameon=False, loc="upper left")
        for axes in figure.axes[2:]:
            axes.set_xlabel("time [min]")
    return figure
