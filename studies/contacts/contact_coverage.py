"""How often what `contact` states of a force is true, in the situations in which a user meets contacts.

A row for each of `situations`, number of sections, sensors and nominal model. All contacts of one draw count. An answer
that is withheld, since no single force explains the readings, and a bound at the largest force that the scene can exert
are counted by themselves.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import make_dataclass
from itertools import product
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.files.row_table import print_rows
from soft_gripper.pictures.style import STYLE, save_figure
from studies.contacts.situations import (
    ARM,
    MODELS,
    PEG,
    STATICS,
    Case,
    Stated,
    carried,
    drawn,
    pressed,
)
from studies.contacts.trials import statistics
from studies.kept_rows import counted_jobs, kept_rows

TABLE, FIGURE = "contact_coverage.csv", "contact_coverage"
SITUATIONS = (*STATICS, *PEG, *ARM)
CASES = tuple(Case(*each) for each in product((2, 4), (False, True), MODELS))
ENOUGH = 92.0  # %, of the bar
FEWEST = 20  # contacts of which a share is stated
CONTACTS, RUNS, CARRIES = 500, 6, 1  # of a situation, by statics, with a peg and with an arm
_TENTHS, _THIRDS = range(1, 10), (("near", 0.1, 0.4), ("middle", 0.4, 0.7), ("far", 0.7, 1.01))
KEYS = "situation", "sections", "sensors", "model"
_STATED = "interval", "transverse", "bound", "bound_beyond", "bound_several", "place"
SHARES = (
    *("contacts", "detected_percent", "withheld_percent", "unbounded_percent", "unbounded_beyond_percent"),
    *(f"{stated}_{which}" for stated in _STATED for which in ("percent", "least_percent", "by_tenth")),
)
_MEASURED, _STATISTICS = ("force_n", "place_percent"), ("mean", "median", "90")
ERRORS = (
    *(f"{error}_{name}_{third[0]}" for error in _MEASURED for third in _THIRDS for name in _STATISTICS),
    "degrees_median",
)
_BANDS = "interval", "transverse"
WIDTHS = (
    *(f"{band}_{kind}_{third[0]}" for band in _BANDS for third in _THIRDS for kind in ("width", "score")),
    "transverse_rms_z",
)
COLUMNS = (*KEYS, *SHARES, *ERRORS, *WIDTHS)
# Cells of numbers stand on the right.
CoverageRow: Any = make_dataclass(
    "CoverageRow", [(name, str if name in KEYS else Annotated[str, ">"]) for name in COLUMNS], frozen=True
)
CoverageRow.__module__ = __name__  # for the processes that make the rows
Job = tuple[str, Case]


def key_of(situation: str, case: Case) -> tuple[str, ...]:
    """The cells that name a row."""
    return situation, str(case.sections), case.sensors, case.model


def coverage_row(situation: str, case: Case, stated: Stated) -> Any:
    """Shares of what is stated that is true, %, and errors of forces, N, and places, % of the length.

    The interval counts where it is stated; bounds where they are below the largest force; the place where it is known.
    A share of each tenth of the length with FEWEST of these or more, and the least of them, are of contacts from 0.1 of
    the length on. Widths of the intervals over the force are medians, scores means, see `interval_score`, of contacts
    that are detected.
    """
    assumed, force = case.assumed, stated.force[:, None]
    bounded = stated.bounds < 0.999 * assumed.largest_force
    far = stated.place > assumed.nearest_contact
    true = {
        "interval": encloses(stated.interval, stated.force),
        "transverse": encloses(stated.transverse_interval, stated.transverse),
        "bound": ((force <= stated.bounds)[:, 0], bounded[:, 0]),
        "bound_beyond": ((force <= stated.bounds)[:, 1], bounded[:, 1] & far),
        "bound_several": ((force <= stated.bounds)[:, 2], bounded[:, 2] & far),
        "place": encloses(stated.places, stated.place),
    }
    row = dict(zip(KEYS, key_of(situation, case), strict=True)) | {
        "contacts": str(len(force)),
        "detected_percent": _percent(stated.probability > DETECTION_PROBABILITY),
        "withheld_percent": _percent(~np.isfinite(stated.interval[:, 0])),
        "unbounded_percent": _percent(~bounded[:, 0]),
        "unbounded_beyond_percent": _percent(~bounded[far, 1]),
    }
    for name, (holds, known) in true.items():
        tenths = [_share(holds, known & (np.minimum((10 * stated.place).astype(int), 9) == i)) for i in _TENTHS]
        row |= {
            f"{name}_percent": _percent(holds[known]),
            f"{name}_least_percent": f"{np.nanmin([*tenths, np.inf]):.1f}",
            f"{name}_by_tenth": " ".join(f"{share:.1f}" for share in tenths),
        }
    errors = np.abs(stated.estimated_force - stated.force), 100 * np.abs(stated.estimated_place - stated.place)
    for name, values in zip(_MEASURED, errors, strict=True):
        for third, begin, end in _THIRDS:
            part = values[(begin <= stated.place) & (stated.place < end) & np.isfinite(values)]
            row |= {f"{name}_{each}_{third}": f"{value:.3g}" for each, value in statistics(part).items()}
    row["degrees_median"] = f"{_average(np.median, stated.degrees[np.isfinite(stated.degrees)]):.2g}"
    detected = (stated.probability > DETECTION_PROBABILITY) & np.isfinite(stated.interval[:, 0])
    for band, interval, true_force in zip(
        _BANDS, (stated.interval, stated.transverse_interval), (stated.force, stated.transverse), strict=True
    ):
        widths, scores = interval[:, -1] - interval[:, 0], interval_score(interval, true_force)
        for third, begin, end in _THIRDS:
            part = detected & (begin <= stated.place) & (stated.place < end)
            row[f"{band}_width_{third}"] = f"{_average(np.median, (widths / true_force)[part]):.3g}"
            row[f"{band}_score_{third}"] = f"{_average(np.mean, (scores / true_force)[part]):.3g}"
    return CoverageRow(**row, transverse_rms_z=f"{rms_z(stated):.3g}")


def interval_score(interval: Array, true: Array) -> Array:
    """Width of intervals of 95 %, (..., 2 or 3), plus 40 times the distance to a true value outside of them, (...).

    The mean is least for the quantiles of what is known: Gneiting and Raftery (2007, doi 10.1198/016214506000001437).
    """
    low, high = interval[..., 0], interval[..., -1]
    outside = np.maximum(low - true, 0) + np.maximum(true - high, 0)
    return np.asarray(high - low + 2 / 0.05 * outside)


def rms_z(stated: Stated) -> float:
    """Error of the transverse force over its standard deviation, root mean square of the detected contacts."""
    z = (stated.estimated_transverse - stated.transverse) / stated.transverse_std
    z = z[(stated.probability > DETECTION_PROBABILITY) & np.isfinite(z)]
    return float(np.sqrt((z**2).mean())) if len(z) else np.nan


def encloses(interval: Array, true: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether intervals, (M, 2 or 3), hold true values, (M), and which intervals are stated."""
    low, high = interval[:, 0], interval[:, -1]
    return (low <= true) & (true <= high), np.isfinite(low)


def _average(function: Callable[[Array], Any], values: Array) -> float:
    """Mean or median; NaN of no values."""
    return float(function(values)) if len(values) else np.nan


def _share(holds: NDArray[np.bool_], known: NDArray[np.bool_]) -> float:
    return 100 * float(holds[known].mean()) if known.sum() >= FEWEST else np.nan


def _percent(holds: NDArray[np.bool_]) -> str:
    return f"{100 * holds.mean():.1f}" if len(holds) else "nan"


def rows_of(kind: str, case: Case, number: float, seed: int) -> list[Any]:
    """The rows of a job: one of a situation by statics, or those of runs with a peg or with an arm.

    `number` is the size of the study, relative to that of the docs.
    """
    if kind in ("peg", "arm"):
        simulated, runs = (pressed, RUNS) if kind == "peg" else (carried, CARRIES)
        found = simulated(case, max(round(number * runs), 1), seed)
        return [coverage_row(situation, case, stated) for situation, stated in found.items()]
    return [coverage_row(kind, case, drawn(STATICS[kind], case, max(round(number * CONTACTS), 1), seed))]


def coverage_jobs() -> dict[Job, list[tuple[str, ...]]]:
    """Kinds and cases of situations, those that take longest first, and the keys of their rows."""
    situations = {"arm": ARM, "peg": PEG} | {name: (name,) for name in reversed(STATICS)}
    return {
        (kind, case): [key_of(situation, case) for situation in situations[kind]]
        for kind, case in product(situations, CASES)
        # With realistic sensors, the task of the arm does not hold its box.
        if situations[kind] and (kind != "arm" or not case.realistic)
    }


_COLORS = "#0072b2", "#009e73", "#d55e00", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999", "#7f3c8d", "#8c564b"


def coverage_figure(rows: Sequence[Any]) -> Figure:
    """Shares of intervals and of bounds that are true, by tenths of the length, a line a situation."""
    panels = list(product(("interval", "bound_beyond"), ("2", "4")))
    cases = list(dict.fromkeys((row.sensors, row.model) for row in rows))
    places = np.array(_TENTHS) / 10 + 0.05
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(cases), 2.3 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), len(cases), sharex=True, sharey=True, squeeze=False)
        for (field, sections), line in zip(panels, axes, strict=True):
            line[0].set_ylabel(f"{sections} sections: {field.replace('_', ', ')}\ntrue [%]")
            for case, panel in zip(cases, line, strict=True):
                panel.axhline(ENOUGH, color="0.6", lw=0.8, ls="--")
                chosen = [row for row in rows if (row.sections, row.sensors, row.model) == (sections, *case)]
                for row in chosen:
                    shares = [float(cell) for cell in getattr(row, f"{field}_by_tenth").split()]
                    color = _COLORS[SITUATIONS.index(row.situation)]
                    panel.plot(places, shares, color=color, marker="o", ms=2.5, lw=1.2, label=row.situation)
                panel.set(ylim=(39, 101), xlim=(0.1, 1))
        for case, panel in zip(cases, axes[0], strict=True):
            panel.set_title(f"{case[0]} sensors; model {case[1]}", fontsize="medium")
        for panel in axes[-1]:
            panel.set_xlabel("contact location / length")
        handles = [mpl.lines.Line2D([], [], color=color) for color in _COLORS]
        figure.legend(handles, SITUATIONS, loc="outside lower center", ncols=5, frameon=False)
    return figure


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file, jobs, settings = options.out / TABLE, coverage_jobs(), {"size": options.size, "seed": options.seed}
    with counted_jobs(options, len(jobs), "cases") as (executor, ended):
        rows = kept_rows(
            *(file, CoverageRow, rows_of, jobs, settings, executor, ended, options.resume),
            order=lambda key: SITUATIONS.index(key[0]),
        )
    save_figure(coverage_figure(rows), options.out / FIGURE)
    # The figure and the table have shares of tenths.
    print_rows(rows, leave=[name for name in COLUMNS if name.endswith("by_tenth")])
    options.console.table("coverage", rows)
    options.console.wrote(file, *(options.out / f"{FIGURE}.{kind}" for kind in ("png", "svg")))
