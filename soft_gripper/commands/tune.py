"""soft-gripper tune: gains for the grip control of a gripper."""

import argparse

from soft_gripper.commands.terminal.console import add_console_options
from soft_gripper.commands.terminal.options import (
    Subparsers,
    add_command,
    add_scheduler_option,
    chosen_station,
    whole_number,
)
from soft_gripper.commands.terminal.tables import print_steps
from soft_gripper.control.pid_controller import PidGains
from soft_gripper.errors import InputError
from soft_gripper.runs.executor import open_executor
from soft_gripper.runs.tuning import follow, tune


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "tune",
        "find gains for the grip control of a gripper",
        "                              for the shipped gripper",
        "my_steps.yaml --evaluations 80",
    )
    add_console_options(parser)
    parser.add_argument("scenario", nargs="?", default="tip_distance_steps", help="a closed-loop scenario")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="change a field of it")
    parser.add_argument("--evaluations", metavar="N", default="50", help="simulations (default: %(default)s)")
    add_scheduler_option(parser)
    parser.set_defaults(command=_run, sections=None)


def _run(options: argparse.Namespace) -> None:
    scenario = chosen_station(options).scenario
    if scenario.control.set_points is None:
        raise InputError(options.scenario, "control.set_points", None, "give set points to be followed")
    evaluations = whole_number("tune", "--evaluations", options.evaluations, 5)
    with options.console.counter(evaluations, "simulations") as bar:

        def report(gains: PidGains, cost: float) -> None:
            bar.set_postfix_str(f"kp {gains.kp:.3g} ki {gains.ki:.3g} kd {gains.kd:.3g}: {cost:.3f} s")
            bar.update()

        with open_executor(1, options.scheduler) as executor:
            gains = tune(scenario, executor, evaluations, report)
    steps = follow(scenario, gains)
    print_steps(steps)
    options.console.table("steps", steps)
    options.console.table("gains", [gains])
    print(f"\ngains: {{ kp: {gains.kp:.4g}, ki: {gains.ki:.4g}, kd: {gains.kd:.4g} }}  # Pa/m, Pa/(m s), Pa s/m")
