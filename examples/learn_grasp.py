"""Learns a gentle grasp with CMA-ES, tests it and the hand-tuned one on unseen objects, and draws the results.

    python examples/learn_grasp.py [FOLDER]

writes learned.yaml, episodes.csv of both, and learning.png and .svg into results/learning, or FOLDER, in about
15 minutes of CPU time.
"""

import csv
import sys
from dataclasses import astuple
from itertools import islice
from pathlib import Path

from gentle_grasp.episodes import (
    Episode,
    hand_tuned_environment,
    learner_environment,
    run_episodes,
    saved_force,
    summary,
)
from gentle_grasp.figure import learning_figure
from gentle_grasp.learn import learn, load_learned, save_learned
from gentle_grasp.policies import GentleGrasp, HandTuned

GENERATIONS, POPULATION, EPISODES, SEED = 9, 8, 8, 1
UNSEEN = range(100)  # seeds of the objects that both are tested on


def write_episodes(file: Path, policies: dict[str, list[Episode]]) -> None:
    """Writes a row for every episode of every policy."""
    with file.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened)
        writer.writerow(["policy", "seed", "success", "peak_force_n"])
        writer.writerows([policy, *astuple(each)] for policy, episodes in policies.items() for each in episodes)


def main(folder: Path) -> None:
    """Learns into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    env, curve = learner_environment(), []
    for parameters, generation in islice(learn(env, POPULATION, EPISODES, SEED), GENERATIONS):
        curve.append(generation)
        save_learned(folder / "learned.yaml", parameters, curve)
        print(generation)
    parameters, curve = load_learned(folder / "learned.yaml")
    learned = run_episodes(env, GentleGrasp(parameters), UNSEEN)
    hand_tuned = run_episodes(hand_tuned_environment(), HandTuned(), UNSEEN)
    print(summary("hand-tuned", hand_tuned), summary("learned", learned), sep="\n")
    print(f"less force by {saved_force(hand_tuned, learned)} N")
    write_episodes(folder / "episodes.csv", {"hand-tuned": hand_tuned, "learned": learned})
    figure = learning_figure(curve, hand_tuned, learned)
    for suffix in ("png", "svg"):
        figure.savefig(folder / f"learning.{suffix}", dpi=200)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/learning"))
