"""Learns a gentle grasp with CMA-ES, tests it and the hand-tuned one on unseen objects, and draws the results.

    python examples/learn_grasp.py [--engine mujoco] [FOLDER]

writes learned.yaml, episodes.csv of both, and learning.png and .svg into results/learning, or FOLDER. The engine is
that of the search, drake or mujoco; the tests are made in Drake.
"""

import argparse
import csv
import time
from dataclasses import astuple
from itertools import islice
from pathlib import Path

from gentle_grasp.episodes import (
    Episode,
    hand_tuned_environments,
    learner_environments,
    run_episodes,
    saved_force,
    summary,
)
from gentle_grasp.figure import learning_figure
from gentle_grasp.learn import learn, load_learned, save_learned
from gentle_grasp.policies import GentleGrasp, HandTuned

GENERATIONS, POPULATION, EPISODES, SEED = 9, 8, 8, 1
UNSEEN = range(200)  # seeds of the objects that both are tested on


def write_episodes(file: Path, policies: dict[str, list[Episode]]) -> None:
    """Writes a row for every episode of every policy."""
    with file.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened)
        writer.writerow(["policy", "seed", "success", "peak_force_n"])
        writer.writerows([policy, *astuple(episode)] for policy, episodes in policies.items() for episode in episodes)


def main(folder: Path, engine: str) -> None:
    """Learns into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.process_time()
    curve = []
    for parameters, generation in islice(learn(learner_environments(engine), POPULATION, EPISODES, SEED), GENERATIONS):
        curve.append(generation)
        save_learned(folder / "learned.yaml", parameters, curve)
        print(generation, flush=True)
    print(f"learned in {time.process_time() - begin:.0f} s of computing time")
    parameters, curve = load_learned(folder / "learned.yaml")
    learned = run_episodes(learner_environments(), [GentleGrasp(parameters) for _ in UNSEEN], UNSEEN)
    hand_tuned = run_episodes(hand_tuned_environments(), [HandTuned() for _ in UNSEEN], UNSEEN)
    print(summary("hand-tuned", hand_tuned), summary("learned", learned), sep="\n")
    print(f"less force by {saved_force(hand_tuned, learned)} N")
    write_episodes(folder / "episodes.csv", {"hand-tuned": hand_tuned, "learned": learned})
    figure = learning_figure(curve, hand_tuned, learned)
    for suffix in ("png", "svg"):
        figure.savefig(folder / f"learning.{suffix}", dpi=200)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("results/learning"))
    parser.add_argument("--engine", choices=("drake", "mujoco"), default="drake")
    given = parser.parse_args()
    main(given.folder, given.engine)
