"""soft-gripper tune: finds gains for the grip control of a gripper."""

import argparse

from soft_gripper.commands.chosen_station import chosen_station
from soft_gripper.control.pid_controller import PidGains
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.tuning import follow, tune
from soft_gripper.files.row_table import print_rows


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    station = chosen_station(options)
    scenario = station.scenario
    if scenario.control.set_points is None:
        raise InputError(options.scenario, "control.set_points", None, "give set points to follow")
    with options.console.counter(options.evaluations, "simulations") as bar:

        def report(gains: PidGains, cost: float) -> None:
            bar.set_postfix_str(f"kp {gains.kp:.3g} ki {gains.ki:.3g} kd {gains.kd:.3g}: {cost:.3f} s")
            bar.update()

        with open_executor(1, options.scheduler) as executor:
            gains = tune(scenario, executor, options.evaluations, report)
    steps = follow(scenario, gains)
    print_rows(steps)
    options.console.table("steps", steps)
    options.console.table("gains", [gains])
    unit = "Pa"
    if not any(finger.finger.pressures for finger in station.fingers):
        unit = "N" if scenario.tendons.command == "tension" else "m"
    units = f"{unit}/m, {unit}/(m s), {unit} s/m"
    print(f"\ngains: {{ kp: {gains.kp:.4g}, ki: {gains.ki:.4g}, kd: {gains.kd:.4g} }}  # {units}")
