"""The example that plays hardware: in closed loop with a bench, and as a serial port."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import simulated_hardware
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


@pytest.mark.slow
def test_it_is_a_serial_port():
    command = [sys.executable, simulated_hardware.__file__, "tip_distance_steps", "--pty"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        with Path(process.stdout.readline().strip()).open("r+b", buffering=0) as port:
            port.write((json.dumps({name: [4e4] for name in COMMANDS}) + "\n").encode())
            lines = (json.loads(port.readline()) for _ in range(100))
            pressures = [line["left_finger.pressure"][0] for line in lines]
        process.terminate()
    assert pressures[-1] == pytest.approx(4e4, rel=0.05)
