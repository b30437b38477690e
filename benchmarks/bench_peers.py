"""The same two fingers in other simulators: the table of docs/benchmarks.md, docs/peers.png and .svg, and the bars.

Every setting of settings.yaml is run, alternately, and of every simulator the fastest one is compared that is as good
as ours under its default: by the error of the tips against the simulator's own converged run where nothing is grasped,
by the creep of the object where something is. Times are CPU time of stepping and sensing, models being built; medians.

    python benchmarks/bench_peers.py [--rounds N] [TASK ...]

Tasks that are named are printed only. Exit code 1: a bar is missed.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import sys
from argparse import ArgumentParser
from pathlib import Path

import yaml
from peers.comparison import Result, chosen, compare, installed
from peers.report import draw, rows, table, write_table

HERE = Path(__file__).parent
FIGURE, PAGE = (HERE.parent / "docs" / name for name in ("peers", "benchmarks.md"))
BARS = {  # by task and simulator: how many times as long as ours it takes, at least
    ("free bending, sensed", "MuJoCo"): 1 / 5,
    ("non-convex grasp", "MuJoCo"): 2.5,
    ("free bending", "PyElastica"): 10.0,
    ("free bending", "PyBullet"): 10.0,
}


def main() -> int:
    """Prints the table, draws the figure; 1 if a bar is missed."""
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
    met = [_print_bar(results[task], task, peer, bar) for (task, peer), bar in BARS.items() if task in results]
    return 0 if all(met) else 1


def _print_bar(results: list[Result], task: str, simulator: str, bar: float) -> bool:
    ours = results[0]
    found = [result for result in chosen(results) if result.simulator == simulator]
    if not found:
        return True
    behind = found[0].times_behind(ours)
    holds = behind >= bar
    equal = "as good as ours" if found[0].matches(ours) else "and is not as good"
    verdict = "at least" if holds else "MISSES"
    print(f"{task}: {simulator} takes {behind:.2g} times as long as ours, {equal}; {verdict} {bar:g}")
    return holds


if __name__ == "__main__":
    sys.exit(main())
