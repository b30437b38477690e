"""One section that is stretched and released, as measured with each preset of sensor errors: twenty sensors each.

    python examples/pictures/sensor_errors.py

draws results/sensor_errors.png, the figure of docs/sensors.md.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import soft_gripper as sg

PERIOD = 0.01  # s
PRESETS = ("realistic", "textile", "liquid_metal", "capacitive", "piezoresistive_elastomer", "optical", "flex_sensor")
FILE = Path("results/sensor_errors.png")

time = PERIOD * np.arange(2000)
strain = 0.1 * np.interp(time % 10, [0, 2, 4, 6, 8], [0, 1, 1, 0, 0])
ratios = np.repeat(1 + strain[:, None, None], 20, axis=1)  # (time, seed, sensor)
figure, rows = plt.subplots(2, 4, figsize=(13, 5), sharex=True, layout="constrained")
rows[1, 3].set_axis_off()
for preset, axes in zip(PRESETS, rows.flat, strict=False):
    errors = sg.scenario.strain_errors(sg.SensorConfig(errors=sg.scenario.StrainErrorsConfig(preset=preset)))
    read = sg.sensors.disturb(errors, ratios, PERIOD, np.random.default_rng(4))[..., 0] - 1
    axes.plot(time, 100 * read, lw=0.5, color="#67a9cf")
    axes.plot(time, 100 * strain, lw=1, color="#b2182b")
    axes.set(title=preset, xlabel="time [s]" if axes in rows[1] else "", ylabel="strain [%]")
FILE.parent.mkdir(exist_ok=True)
figure.savefig(FILE, dpi=120)
