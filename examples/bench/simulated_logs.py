"""Writes the logs of a bench that the how-to pages use: a simulation stands in for the hardware.

The simulated finger is 8 % softer than its file, and its gauges have errors. Both commands read my_finger.yaml, from
the current folder, and write free.csv, a log of free bending. The second one writes press.csv too, in which the finger
of press.yaml presses on a block on a scale that shows whole grams, 0.4 s late, and drifts by 2 g a minute:

    python examples/bench/simulated_logs.py
    python examples/bench/simulated_logs.py scale
"""

import sys
from pathlib import Path

import numpy as np

import soft_gripper as sg

GRAM = 9.80665e-3  # N
SOFTER = ["models.finger.fingers.all.youngs_modulus=-8 %", "models.finger.fingers.all.layer_modulus=-8 %"]
ERRORS = "sensor.errors={gain_error: 0.03, offset: 0.005, hysteresis: 0.01, drift: 1.0e-3, noise: 2.0e-3}"
FREE = [0, 40e3, 80e3, 120e3, 150e3, 110e3, 70e3, 30e3, 0, 60e3, 120e3, 60e3, 0]  # Pa
PRESSES = [0, 50e3, 0, 75e3, 0, 60e3, 0, 70e3, 0]  # Pa
BLOCKS = (0.058, 0.179), (0.075, 0.178), (0.092, 0.177), (0.110, 0.176)  # m, x and z in four runs


def simulated(name, steps, samples, *changes):
    """Signals of a scenario whose pressure takes steps, each held for 0.5 s and a number of samples."""
    held = [f"pressure.steps.all={steps}", "pressure.settle=0.5", f"pressure.hold_samples={samples}"]
    changes = [*SOFTER, ERRORS, *held, "estimator.type=arcs", "sensor.seed=5", *changes]
    return sg.simulate(sg.load_scenario(name, changes)).data


def rows(data, *columns, begin=0.0):
    """Time (s), counts of the gauges, pressure (kPa) and further columns, a row for each sample."""
    counts = data["finger.strain"].values.reshape(len(data["time"]), -1).round()
    pressure = data["finger.sampled_pressure"].values.reshape(-1, 1) / 1e3
    return np.column_stack([begin + data["time"].values, counts, pressure, *columns])


def write(name, table):
    """Writes rows to a file, as a microcontroller sends them."""
    np.savetxt(name, table, fmt="%.6g", delimiter=",")


def log_free_bending():
    """Writes free bending with the tip, x and z to a millimetre, as a camera sees it."""
    data = simulated("my_finger.yaml", FREE, 60)
    write("free.csv", rows(data, data["finger.true_tip_position"].values[:, ::2].round(3)))


def log_presses():
    """Writes free bending and presses with the weight that a scale shows (g) and the location of the block (mm)."""
    free = simulated("my_finger.yaml", FREE, 60)
    samples = len(free["time"])
    write("free.csv", rows(free, np.zeros(samples), np.full(samples, 60)))
    runs, begin = [], 0.0
    for x, z in BLOCKS:
        data = simulated(
            Path(__file__).with_name("press.yaml"), PRESSES, 350, f"models.block.X_PC.translation=[{x}, 0, {z}]"
        )
        time = data["time"].values
        shown = np.floor(time / 0.1) * 0.1  # when the display changes
        drift = 3 + 2 / 60 * (begin + shown)  # g
        weight = np.interp(shown - 0.4, time, data["finger.true_contact_force_world"].values[:, 2]) / GRAM
        place = np.round(1e3 * np.nanmedian(data["finger.true_contact_arc_length"]))
        runs.append(rows(data, (weight + drift).round(), np.full(len(time), place), begin=begin))
        begin += time[-1] + 30
    write("press.csv", np.vstack(runs))


if __name__ == "__main__":
    log_presses() if sys.argv[1:] == ["scale"] else log_free_bending()
