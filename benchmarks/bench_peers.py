"""The same two fingers in other simulators: the table of docs/benchmarks.md, docs/peers.png and .svg.

Every setting of settings.yaml is run, alternately, and of every simulator the fastest one is compared that is as good
as ours under its default: by the error of the tips against the simulator's own converged run where nothing is grasped,
by the creep of the object where something is. Times are CPU time of stepping and sensing, models being built; medians.

    python benchmarks/bench_peers.py [--rounds N] [TASK ...]

Tasks that are named are printed only. What README and docs say of the table is tested by
tests/benchmarks/test_peers_sentences.py.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from argparse import ArgumentParser
from pathlib import Path

import yaml
from peers.comparison import compare, installed
from peers.report import draw, rows, table, write_table

HERE = Path(__file__).parent
FIGURE, PAGE = (HERE.parent / "docs" / name for name in ("peers", "benchmarks.md"))


def main() -> None:
    """Prints the table and draws the figure."""
    config = yaml.safe_load((HERE / "peers" / "settings.yaml").read_text())
    parser = ArgumentParser(description="The same two fingers in other simulators.")
    parser.add_argument("tasks", nargs="*", choices=[*config["tasks"], []], metavar="TASK")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    tasks, simulators = arguments.tasks or list(config["tasks"]), installed(config["simulators"])
    results = {}
    print(*table([]), sep="\n", flush=True)
    for task in tasks:
        results[task] = compare(task, config, simulators, arguments.rounds)
        print(*rows(results[task]), sep="\n", flush=True)
    if not arguments.tasks:
        write_table(PAGE, results.values())
        draw(results, FIGURE)


if __name__ == "__main__":
    main()
