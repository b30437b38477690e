"""Shape and force during an hour of grasping with sensors that drift: the command.

In: rows of parts, see `hour`. Out: their summary, figure and claims. Another claim is one of `drift_claims`.
"""

import argparse
from collections.abc import Sequence
from itertools import product

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.commands.printing import print_claims
from soft_gripper.files.row_table import columns, print_rows
from soft_gripper.pictures.style import STYLE, save_figure
from studies.drift.hour import MINUTES, POLICIES, DriftRow, PolicyRow, drift_rows
from studies.kept_rows import counted_jobs, kept_rows

TABLE, SUMMARY, FIGURE = "drift_parts.csv", "drift.csv", "drift"
COVERED = 90.0, 99.0  # %, at the last minute, under each policy
MAX_TIP = 2.9  # % of the length, under the best policy
_STATED = "force_error_n", "force_width_n", "force_covered_percent", "force_rms_z"  # columns of stated intervals


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if a claim does not hold."""
    console, out, seed = options.console, options.out, {"seed": options.seed}
    keys = list(product(POLICIES, map(str, MINUTES)))
    jobs = {(part,): [(str(part), *key) for key in keys] for part in range(options.parts)}
    with counted_jobs(options, len(jobs), "hours") as (executor, ended):
        parts = kept_rows(out / TABLE, DriftRow, drift_rows, jobs, seed, executor, ended, options.resume)
    rows = summary(parts)
    claims = drift_claims(rows)
    print_rows(rows)
    console.table("drift", rows, out / SUMMARY)
    save_figure(drift_figure(rows), out / FIGURE)
    print_claims(claims)
    console.table("claims", claims)
    console.wrote(*(out / file for file in (SUMMARY, TABLE, f"{FIGURE}.png", f"{FIGURE}.svg")))
    return 0 if all(claim.holds for claim in claims) else 1


def summary(rows: Sequence[DriftRow]) -> list[PolicyRow]:
    """Joins all parts by policy and minute, in the order of the rows."""
    groups: dict[tuple[str, int], list[DriftRow]] = {}
    for row in rows:
        groups.setdefault((row.policy, row.minute), []).append(row)
    summaries = []
    for (policy, minute), parts in groups.items():
        samples = np.array([row.samples for row in parts])
        stated_counts = samples * [row.force_stated_percent for row in parts]
        means = {
            name: float(
                np.average([getattr(row, name) for row in parts], weights=stated_counts if name in _STATED else samples)
            )
            for name in columns(PolicyRow)
            if name not in ("policy", "minute", "samples")
        }
        summaries.append(PolicyRow(policy=policy, minute=minute, **means, samples=int(samples.sum())))
    return summaries


def drift_claims(rows: Sequence[PolicyRow]) -> list[Claim]:
    """Claims about the last minute: coverage under every policy, and the error under the best one."""
    last = [row for row in rows if row.minute == rows[-1].minute]
    best = min(last, key=lambda row: row.tip_percent)
    bounds = " to ".join(f"{percent:.0f}" for percent in COVERED)
    claims = []
    for row in last:
        shape, force = row.shape_covered_percent, row.force_covered_percent
        holds = min(shape, force) >= COVERED[0] and max(shape, force) <= COVERED[1]
        text = f"minute {row.minute}, {row.policy}: 95 % bands of shape and force cover {bounds} %"
        claims.append(Claim("ours", text, holds, f"{shape:.1f} and {force:.1f} %"))
    text = f"minute {best.minute}, best policy: tip within {MAX_TIP} % of the length in the mean"
    holds = best.tip_percent <= MAX_TIP
    return [*claims, Claim("ours", text, holds, f"{best.tip_percent:.2f} %, {best.policy}")]


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
                policy_rows = [row for row in rows if row.policy == policy]
                values = [getattr(row, name) for row in policy_rows]
                axes.plot([row.minute for row in policy_rows], values, "o-", ms=3.5, lw=1.4, color=color, label=policy)
            axes.set_ylabel(label)
            if name.endswith("covered_percent"):
                axes.axhspan(*COVERED, color="0.9", zorder=0)
                axes.set_ylim(top=101)
            else:
                axes.set_ylim(bottom=0)
            if name == "tip_percent":
                axes.axhline(MAX_TIP, color="0.5", lw=0.8, ls="--")
                axes.legend(title="sensors zeroed", frameon=False, loc="upper left")
        for axes in figure.axes[2:]:
            axes.set_xlabel("time [min]")
    return figure
