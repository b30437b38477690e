"""Coverage of the intervals and bounds of `contact`, in the situations in which a user meets contacts.

In: the situations of `situations` and SETUPS. Out: a row for each pair, and a figure of coverage along the finger. All
contacts of one draw count. An answer that is withheld, since no single force explains the readings, and a bound at the
largest force that the scene can exert are counted by themselves. Another statement is a key of `coverage` in
`coverage_cells`.
"""

import argparse
from collections.abc import Sequence
from dataclasses import make_dataclass
from itertools import product
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.files.row_table import print_rows
from soft_gripper.pictures.style import STYLE, save_figure
from studies.contacts.estimates import Estimates
from studies.contacts.situations import ARM, PEG, STATICS, arm_estimates, peg_estimates, static_estimates
from studies.contacts.trials import statistics
from studies.estimator_setup import MODELS, EstimatorSetup
from studies.kept_rows import counted_jobs, kept_rows

TABLE, FIGURE = "contact_coverage.csv", "contact_coverage"
SITUATIONS = (*STATICS, *PEG, *ARM)
SETUPS = tuple(EstimatorSetup(*values) for values in product((2, 4), (0.0, 1.0), MODELS))
TARGET = 92.0  # %, coverage
MIN_CONTACTS = 20  # in a tenth whose coverage counts
CONTACTS, RUNS, CARRIES = 500, 6, 1  # of a situation: by statics, with a peg, with an arm
_TENTHS, _THIRDS = range(1, 10), (("near", 0.1, 0.4), ("middle", 0.4, 0.7), ("far", 0.7, 1.01))
KEYS = "situation", "sections", "sensors", "model"


def row_key(situation: str, setup: EstimatorSetup) -> tuple[str, ...]:
    """The cells that name a row."""
    return situation, str(setup.sections), setup.sensors, setup.model


def coverage_cells(estimates: Estimates, setup: EstimatorSetup) -> dict[str, str]:
    """Coverage of intervals, bounds and locations, %, and errors of forces, N, and locations, % of the length.

    Intervals count where they are stated, bounds where they are below the largest force, locations where they are
    known. Coverage of each tenth of the length with MIN_CONTACTS or more, and the least of them, are of contacts from
    0.1 of the length on. Widths of the intervals over the force are medians, scores means, see `interval_score`, of
    contacts that are detected.
    """
    uncertainty, force, location = setup.uncertainty, estimates.force, estimates.location
    is_bounded = estimates.bounds < 0.999 * uncertainty.largest_force
    is_far, is_below = location > uncertainty.nearest_contact, force[:, None] <= estimates.bounds
    bands = {
        "interval": (estimates.interval, force),
        "transverse": (estimates.transverse_interval, estimates.transverse),
    }
    coverage = {name: encloses(*band) for name, band in bands.items()} | {
        "bound": (is_below[:, 0], is_bounded[:, 0]),
        "bound_beyond": (is_below[:, 1], is_bounded[:, 1] & is_far),
        "bound_several": (is_below[:, 2], is_bounded[:, 2] & is_far),
        "place": encloses(estimates.location_set, location),
    }
    cells = {
        "contacts": str(len(force)),
        "detected_percent": _percent(estimates.is_detected),
        "withheld_percent": _percent(~np.isfinite(estimates.interval[:, 0])),
        "unbounded_percent": _percent(~is_bounded[:, 0]),
        "unbounded_beyond_percent": _percent(~is_bounded[is_far, 1]),
    }
    for name, (covers, is_counted) in coverage.items():
        tenths = [is_counted & (np.minimum((10 * location).astype(int), 9) == i) for i in _TENTHS]
        percents = [100 * covers[tenth].mean() if tenth.sum() >= MIN_CONTACTS else np.nan for tenth in tenths]
        cells |= {
            f"{name}_percent": _percent(covers[is_counted]),
            f"{name}_least_percent": f"{np.nanmin([*percents, np.inf]):.1f}",
            f"{name}_by_tenth": " ".join(f"{percent:.1f}" for percent in percents),
        }
    errors = {
        "force_n": np.abs(np.abs(estimates.estimated_force) - force),
        "place_percent": 100 * np.abs(estimates.estimated_location - location),
    }
    thirds = {name: (begin <= location) & (location < end) for name, begin, end in _THIRDS}
    for (name, values), (third, inside) in product(errors.items(), thirds.items()):
        numbers = statistics(values[inside & np.isfinite(values)])
        cells |= {f"{name}_{key}_{third}": f"{value:.3g}" for key, value in numbers.items()}
    cells["degrees_median"] = f"{statistics(estimates.degrees[np.isfinite(estimates.degrees)])['median']:.2g}"
    is_detected = estimates.is_detected & np.isfinite(estimates.interval[:, 0])
    for (name, (interval, true)), (third, inside) in product(bands.items(), thirds.items()):
        widths, scores = (interval[:, -1] - interval[:, 0]) / true, interval_score(interval, true) / true
        cells[f"{name}_width_{third}"] = f"{statistics(widths[is_detected & inside])['median']:.3g}"
        cells[f"{name}_score_{third}"] = f"{statistics(scores[is_detected & inside])['mean']:.3g}"
    return cells | {"transverse_rms_z": f"{rms_z(estimates):.3g}"}


def interval_score(interval: Array, true: Array) -> Array:
    """Width of intervals of 95 %, (..., 2 or 3), plus 40 times the distance to a true value outside of them, (...).

    The quantiles of the true distribution have the least mean: Gneiting and Raftery (2007, doi
    10.1198/016214506000001437).
    """
    low, high = interval[..., 0], interval[..., -1]
    outside = np.maximum(low - true, 0) + np.maximum(true - high, 0)
    return np.asarray(high - low + 2 / 0.05 * outside)


def rms_z(estimates: Estimates) -> float:
    """Error of the transverse force over its standard deviation, root mean square of the detected contacts."""
    z = (estimates.estimated_transverse - estimates.transverse) / estimates.transverse_std
    z = z[estimates.is_detected & np.isfinite(z)]
    return float(np.sqrt((z**2).mean())) if len(z) else np.nan


def encloses(interval: Array, true: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Intervals, (M, 2 or 3), that hold true values, (M,), and intervals that are stated, masks (M,)."""
    low, high = interval[:, 0], interval[:, -1]
    return (low <= true) & (true <= high), np.isfinite(low)


def _percent(mask: NDArray[np.bool_]) -> str:
    return f"{100 * mask.mean():.1f}" if len(mask) else "nan"


_EMPTY = Estimates(*(np.empty((0, *shape)) for shape in (*11 * [()], (3,), (3,), (2,), (3,))))
COLUMNS = (*KEYS, *coverage_cells(_EMPTY, SETUPS[0]))
# Cells of numbers stand on the right.
CoverageRow: Any = make_dataclass(
    "CoverageRow", [(name, str if name in KEYS else Annotated[str, ">"]) for name in COLUMNS], frozen=True
)
CoverageRow.__module__ = __name__  # for the processes that make the rows


def coverage_row(situation: str, setup: EstimatorSetup, estimates: Estimates) -> Any:
    """The row of a situation and a setup."""
    return CoverageRow(*row_key(situation, setup), **coverage_cells(estimates, setup))


def coverage_rows(kind: str, setup: EstimatorSetup, size: float, seed: int) -> list[Any]:
    """Rows of a job: of a situation by statics, or of runs with a peg or with an arm.

    `size` is that of the study, relative to that of the docs.
    """
    if kind in ("peg", "arm"):
        simulate, runs = (peg_estimates, RUNS) if kind == "peg" else (arm_estimates, CARRIES)
        estimates = simulate(setup, max(round(size * runs), 1), seed)
    else:
        estimates = {kind: static_estimates(STATICS[kind], setup, max(round(size * CONTACTS), 1), seed)}
    return [coverage_row(situation, setup, contacts) for situation, contacts in estimates.items()]


def coverage_jobs() -> dict[tuple[str, EstimatorSetup], list[tuple[str, ...]]]:
    """Kinds of situations and setups, the longest first, with the keys of their rows."""
    situations = {"arm": ARM, "peg": PEG} | {name: (name,) for name in reversed(STATICS)}
    return {
        (kind, setup): [row_key(situation, setup) for situation in situations[kind]]
        for kind, setup in product(situations, SETUPS)
        # With realistic sensors, the task of the arm does not hold its box.
        if situations[kind] and (kind != "arm" or not setup.noise)
    }


_COLORS = "#0072b2", "#009e73", "#d55e00", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999", "#7f3c8d", "#8c564b"


def coverage_figure(rows: Sequence[Any]) -> Figure:
    """Coverage of intervals and of bounds by tenths of the length, %, a line a situation."""
    panels = list(product(("interval", "bound_beyond"), ("2", "4")))
    setups = list(dict.fromkeys((row.sensors, row.model) for row in rows))
    locations = np.array(_TENTHS) / 10 + 0.05
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(setups), 2.3 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), len(setups), sharex=True, sharey=True, squeeze=False)
        for (field, sections), line in zip(panels, axes, strict=True):
            line[0].set_ylabel(f"{sections} sections: {field.replace('_', ', ')}\ntrue [%]")
            for setup, panel in zip(setups, line, strict=True):
                panel.axhline(TARGET, color="0.6", lw=0.8, ls="--")
                panel_rows = [row for row in rows if (row.sections, row.sensors, row.model) == (sections, *setup)]
                for row in panel_rows:
                    percents = [float(cell) for cell in getattr(row, f"{field}_by_tenth").split()]
                    color = _COLORS[SITUATIONS.index(row.situation)]
                    panel.plot(locations, percents, color=color, marker="o", ms=2.5, lw=1.2, label=row.situation)
                panel.set(ylim=(39, 101), xlim=(0.1, 1))
        for setup, panel in zip(setups, axes[0], strict=True):
            panel.set_title(f"{setup[0]} sensors; model {setup[1]}", fontsize="medium")
        for panel in axes[-1]:
            panel.set_xlabel("contact location / length")
        handles = [mpl.lines.Line2D([], [], color=color) for color in _COLORS]
        figure.legend(handles, SITUATIONS, loc="outside lower center", ncols=5, frameon=False)
    return figure


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file = options.out / TABLE
    jobs = coverage_jobs()
    settings = {"size": options.size, "seed": options.seed}
    with counted_jobs(options, len(jobs), "cases") as (executor, ended):
        rows = kept_rows(
            *(file, CoverageRow, coverage_rows, jobs, settings, executor, ended, options.resume),
            order=lambda key: SITUATIONS.index(key[0]),
        )
    save_figure(coverage_figure(rows), options.out / FIGURE)
    # The figure and the table have coverage by tenths.
    print_rows(rows, leave=[name for name in COLUMNS if name.endswith("by_tenth")])
    options.console.table("coverage", rows)
    options.console.wrote(file, *(options.out / f"{FIGURE}.{kind}" for kind in ("png", "svg")))
