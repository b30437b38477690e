"""Compares two fingers in other simulators: the table of docs/benchmarks.md, docs/peers.png and .svg.

Every setting of settings.yaml is run, alternately, and of every simulator the fastest one is compared that is as good
as ours under its default: by the error of the tips against the simulator's converged run if nothing is grasped,
else by the creep of the object. Times are medians of CPU time of stepping and sensing, without building the models.

Named tasks are only printed. Sentences of README and docs on the table are tested by
tests/studies/peers/test_peers_sentences.py.
"""

import argparse
from pathlib import Path

import yaml

from soft_gripper.files.document import require
from studies import ROOT
from studies.page_table import write_table
from studies.peers.comparison import compare, installed_simulators
from studies.peers.report import draw, rows, table

FIGURE, PAGE = (ROOT / "docs" / name for name in ("peers", "benchmarks.md"))


def run(options: argparse.Namespace) -> None:
    """Prints the table and draws the figure."""
    config = yaml.safe_load(Path(__file__).with_name("settings.yaml").read_text(encoding="utf-8"))
    for task in options.tasks:
        require(task in config["tasks"], "peers", "TASK", task, f"known: {', '.join(config['tasks'])}")
    tasks = options.tasks or list(config["tasks"])
    simulators = installed_simulators(config["simulators"])
    results = {}
    print(*table([]), sep="\n", flush=True)
    for task in tasks:
        results[task] = compare(task, config, simulators, options.rounds)
        print(*rows(results[task]), sep="\n", flush=True)
    if not options.tasks:
        write_table(PAGE, table(results.values()))
        draw(results, FIGURE)
