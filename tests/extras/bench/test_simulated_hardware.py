"""The example that plays hardware: in closed loop with a bench, and as a serial port."""

import numpy as np
import pytest
from simulated_hardware import SimulatedHardware

from soft_gripper.extras.bench.bench import Bench
from soft_gripper.scenario.scenario_file import load_scenario

SET_POINT = 0.06  # m, the first of the scenario
COMMANDS = [f"{side}_finger.pressure_command" for side in ("left", "right")]


def test_the_opening_reaches_its_set_point():
    scenario = load_scenario("tip_distance_steps")
    hardware, bench = SimulatedHardware(scenario), Bench(scenario)
    for _ in range(230):
        message = hardware.message()
        bench.step({name: np.ravel(message[name]) for name in bench.inputs})
        hardware.command(bench.read(COMMANDS))
    assert bench.read(["grip.opening"])["grip.opening"][0] == pytest.approx(SET_POINT, abs=2e-3)
