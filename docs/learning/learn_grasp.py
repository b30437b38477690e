"""Learns a gentle grasp with CMA-ES, tries it and the hand-tuned one on unseen objects, and draws what came of it.

    python docs/learning/learn_grasp.py [FOLDER]

writes learned.yaml, episodes.csv of both, and learning.png and .svg into results/learning, or FOLDER, in about
15 minutes of CPU time.
"""

import sys
from dataclasses import astuple, dataclass
from itertools import islice
from pathlib import Path

from soft_gripper.files.csv_table import write_csv
from soft_gripper.learning.gentle_grasp.compare import saved_force, summary
from soft_gripper.learning.gentle_grasp.episodes import (
    Episode,
    hand_tuned_environment,
    learner_environment,
    run_episodes,
)
from soft_gripper.learning.gentle_grasp.learn import learn
from soft_gripper.learning.gentle_grasp.learned import load_learned, save_learned
from soft_gripper.learning.gentle_grasp.learning_figure import learning_figure
from soft_gripper.learning.gentle_grasp.policies import GentleGrasp, HandTuned
from soft_gripper.pictures.style import save_figure

GENERATIONS, POPULATION, EPISODES, SEED = 9, 8, 8, 1
UNSEEN = range(100)  # seeds of the objects that both are tried on


@dataclass(frozen=True)
class EpisodeRow:
    """One episode of one policy."""

    policy: str
    seed: int
    success: bool
    peak_force_n: float


def rows(policy: str, episodes: list[Episode]) -> list[EpisodeRow]:
    """Rows of a table."""
    return [EpisodeRow(policy, *astuple(episode)) for episode in episodes]


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
    write_csv(folder / "episodes.csv", [*rows("hand-tuned", hand_tuned), *rows("learned", learned)])
    save_figure(learning_figure(curve, hand_tuned, learned), folder / "learning")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/learning"))
