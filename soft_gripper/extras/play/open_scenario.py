"""Scenarios whose commands are left to a user."""

from dataclasses import replace

from soft_gripper.scenario.schema import Scenario


def open_scenario(scenario: Scenario, grip: str | None = None) -> Scenario:
    """A scenario without its task, set points and pressure steps.

    Args:
        scenario: its models, sensors, estimators, controllers and solver are kept.
        grip: what commands the fingers: the "pressure" of each, or the "opening", held in closed loop; None: the
            opening if the scenario closes that loop.
    """
    closes_loop = scenario.control.set_points is not None or (scenario.task is not None and scenario.task.grips)
    command = grip or ("opening" if closes_loop or "opening" in scenario.external else "pressure")
    external = [command] if scenario.arm is None else [command, "tool"]
    return replace(scenario, task=None, control=replace(scenario.control, set_points=None), external=external)
