"""How the gentle grasp was learned, and its forces compared with those of the hand-tuned grasp."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gentle_grasp.episodes import Episode
from gentle_grasp.learn import Generation

_HAND_TUNED_COLOR, _LEARNED_COLOR, _SUCCESS_COLOR = "C1", "C2", "C0"
_FIGURE_STYLE = {
    "font.size": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.3,
}


def learning_figure(curve: Sequence[Generation], hand_tuned: Sequence[Episode], learned: Sequence[Episode]) -> Figure:
    """Left the best cost and the successes of every generation, right the forces of both grasps, object by object."""
    with mpl.rc_context(_FIGURE_STYLE):
        figure = Figure(figsize=(8.2, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=[1.2, 1.0])
        _draw_curve(left, curve)
        _draw_forces(right, hand_tuned, learned)
        return figure


def _draw_curve(axes: Axes, curve: Sequence[Generation]) -> None:
    episodes = [generation.episodes for generation in curve]
    axes.plot(episodes, [generation.best_cost for generation in curve], "o-", color=_LEARNED_COLOR, ms=4)
    axes.set(xlabel="episodes", ylabel="mean peak force, best candidate [N]", ylim=(0, 0.75))
    axes.yaxis.label.set_color(_LEARNED_COLOR)
    other = axes.twinx()
    other.plot(episodes, [100 * generation.success for generation in curve], "s--", color=_SUCCESS_COLOR, ms=3.5)
    other.set(ylabel="held up by all candidates [%]", ylim=(0, 103))
    other.grid(visible=False)
    other.spines["right"].set_visible(True)
    axes.set_title("learning, half of it with the hardest objects")


def _draw_forces(axes: Axes, hand_tuned: Sequence[Episode], learned: Sequence[Episode]) -> None:
    for name, color, episodes in (("hand-tuned", _HAND_TUNED_COLOR, hand_tuned), ("learned", _LEARNED_COLOR, learned)):
        forces = np.sort([episode.peak_force for episode in episodes])
        held = sum(episode.success for episode in episodes)
        label = f"{name} ({held} of {len(episodes)})"
        axes.step(forces, 100 * np.arange(1, len(forces) + 1) / len(forces), where="post", color=color, label=label)
    axes.set(xlabel="peak force [N]", ylabel="objects below it [%]", ylim=(0, 103), xlim=(0.4, 1.1))
    axes.legend(loc="lower right", frameon=False, title="held up")
    axes.set_title("unseen objects")
