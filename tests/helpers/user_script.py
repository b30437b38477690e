"""A script as a user would write it, whose types are checked and which is run; see commands/test_wheel.py."""

from pathlib import Path

import numpy as np

import soft_gripper as sg


def worst_error(recording: sg.Recording, finger: str) -> float:
    """The largest pose error, mm."""
    return 1e3 * float(np.nanmax(recording[f"{finger}.pose_error"].values))


changes = ["pressure.steps={all: [0, 75e3]}", "pressure.settle=0.2", "nominal.finger.youngs_modulus=+10 %"]
scenario = sg.load_scenario("free_bending", [*changes, "sensor.sections=2"])
errors: dict[str, float] = {}
for estimator in ("arcs", "gaussian"):
    scenario.estimator = sg.EstimatorConfig(type=estimator)
    errors[estimator] = worst_error(sg.simulate(scenario), "left_finger")
print({name: round(error, 2) for name, error in errors.items()})

station = sg.make_station(scenario)
finger: sg.fingers.Finger = station.fingers[0].finger
layout = sg.sensors.SensorLayout(finger, sections=3)
print(layout.section_ends, sg.estimators.Uncertainty(reading=1e-3))
recording = sg.run_station(station)
settled = sg.runs.held_samples(scenario, recording, "left_finger.pressure").mean(axis=1)
recording.plot("left_finger.pressure", "left_finger.pose_error").savefig("errors.png")
recording.save(Path("free_bending.nc"))
print(settled, sg.scenario_names())
