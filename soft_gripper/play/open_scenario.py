"""A scenario with its commands left open, for whoever moves the sliders."""

from dataclasses import replace

from soft_gripper.scenario.scenario import Scenario

GRIPS = ("pressure", "opening")


def open_scenario(scenario: Scenario, grip: str | None = None) -> Scenario:
    """The same scene without its task, its set points and its steps of pressure.

    Args:
        scenario: of which models, sensors, estimators, controllers and solver stay.
        grip: what commands the fingers: the "pressure" of each, or the "opening", held in closed loop; None: the
            opening where the scenario closes that loop.
    """
    closes_loop = scenario.control.set_points is not None or (scenario.task is not None and scenario.task.grips)
    chosen = grip or ("opening" if closes_loop or "opening" in scenario.external else "pressure")
    external = [chosen] if scenario.arm is None else [chosen, "tool"]
    return replace(scenario, task=None, control=replace(scenario.control, set_points=None), external=external)
