"""The options of commands that run many simulations."""

import argparse
from concurrent.futures import Executor
from contextlib import AbstractContextManager

from soft_gripper.commands.terminal.numbers import number_of_jobs
from soft_gripper.evaluation.executor.executor import open_executor


def add_executor_options(parser: argparse.ArgumentParser) -> None:
    """Where simulations run that are many."""
    parser.add_argument("--jobs", metavar="N", help="processes (default: one a core)")
    add_scheduler_option(parser)


def add_scheduler_option(parser: argparse.ArgumentParser) -> None:
    """A cluster, in the place of processes."""
    address = "Dask scheduler, such as tcp://127.0.0.1:8786, whose workers are used instead; see docs/cluster.md"
    parser.add_argument("--scheduler", metavar="URL", help=address)


def chosen_executor(command: str, options: argparse.Namespace) -> AbstractContextManager[Executor]:
    """The executor that the options of `add_executor_options` name."""
    return open_executor(number_of_jobs(command, options.jobs), options.scheduler)
