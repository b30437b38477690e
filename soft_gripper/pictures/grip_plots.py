"""The signals of a grip against time, over the phases of its task."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from soft_gripper.diagrams.recording.phase_spans import Span
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.scenario.scenario import Scenario

MEASURED: dict[str, Any] = {"color": "#33608c", "lw": 1.4}
WANTED: dict[str, Any] = {"color": "0.35", "lw": 0.9, "ls": (0, (4, 2))}
THRESHOLD: dict[str, Any] = {"color": "0.35", "lw": 0.9, "ls": (0, (1, 1.5))}
SHADES = ("0.93", "0.98")
_CHARACTER = 0.053  # inches that a character of a phase's name takes


def recorded_plots(recording: Recording) -> list[str]:
    """The plots that there are signals for: pressure always, opening and torque where the gripper was commanded."""
    return [*(["opening", "torque"] if "grip.opening" in recording.data else []), "pressure"]


def draw_grip_plots(plots: Sequence[Axes], scenario: Scenario, recording: Recording, spans: Sequence[Span]) -> None:
    """The plots of `recorded_plots`, one below the other; legends to their right, names of the phases above."""
    draw = {"opening": _draw_opening, "torque": _draw_torque, "pressure": _draw_pressure}
    for axes, name in zip(plots, recorded_plots(recording), strict=True):
        draw[name](axes, scenario, recording)
    plots[-1].set_xlabel("time [s]", labelpad=1)
    for axes in plots:
        axes.set_xlim(0, float(recording.data["time"][-1]))
        axes.margins(y=0.12)
        axes.tick_params(labelbottom=axes is plots[-1])
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4, fontsize="small")
        for i, span in enumerate(spans):
            axes.axvspan(span.begin, span.end, color=SHADES[i % 2], lw=0, zorder=0)
    _name_spans(plots[0], spans)


def _draw_opening(axes: Axes, scenario: Scenario, recording: Recording) -> None:
    _plot(axes, recording, 1e3, "grip.set_point", "set point", WANTED)
    _plot(axes, recording, 1e3, "grip.opening", "estimated", MEASURED)
    axes.set_ylabel("opening\n[mm]")


def _draw_torque(axes: Axes, scenario: Scenario, recording: Recording) -> None:
    if scenario.control.torque_limit is not None:
        axes.axhline(1e3 * scenario.control.torque_limit, label="limit", **WANTED)
    _plot(axes, recording, 1e3, "grip.torque", "estimated", MEASURED)
    assert scenario.task is not None
    axes.axhline(1e3 * scenario.task.grip_threshold, label="counts as grip", **THRESHOLD)
    axes.set_ylabel("grip torque\n[mN m]")


def _draw_pressure(axes: Axes, scenario: Scenario, recording: Recording) -> None:
    fingers = [str(name) for name in recording.data if str(name).endswith(".pressure")]
    _plot(axes, recording, 1e-3, f"{fingers[0]}_command", "command", WANTED)
    for name in fingers:
        _plot(axes, recording, 1e-3, name, "in the fingers" if name == fingers[0] else "", MEASURED)
    axes.set_ylabel("pressure\n[kPa]")


def _plot(axes: Axes, recording: Recording, unit: float, signal: str, label: str, look: dict[str, Any]) -> None:
    axes.plot(recording.data["time"], unit * recording[signal], label=label, **look)


def _name_spans(axes: Axes, spans: Sequence[Span]) -> None:
    """Number and name over every phase; where there is no room for the name, the number."""
    (begin, end), width = axes.get_xlim(), axes.get_window_extent().width / axes.figure.dpi
    for i, span in enumerate(spans, 1):
        text = f"{i} {span.phase.name}"
        fits = _CHARACTER * len(text) < width * (span.end - span.begin) / (end - begin)
        middle = ((span.begin + span.end) / 2, 1.04)
        axes.annotate(
            text if fits else str(i), middle, xycoords=axes.get_xaxis_transform(), ha="center", fontsize="small"
        )
