"""A finger that presses on a scale, by statics: its log, as a bench writes it, and what describes it."""

from pathlib import Path

import numpy as np
from loaded_fingers import Push, in_balance
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout

SCENARIO = """models:
- name: finger
  file: package://soft_gripper/grippers/finger.urdf
gravity: [0, 0, -9.81]
sensor: { sections: 2, borders: [0.333], period: 0.02 }
estimator: { type: contact, uncertainty: { reading: 1.0e-3, bend_per_pressure: 0.005 } }
"""
BENCH = """source: "file:press.csv"
format: text
fields: [t, a, b, c, d, p, scale, mm, base, turn]
time: t
pressure_unit: kPa
pause: 5
fingers:
  finger:
    readings: [a, b, c, d]
    pressures: [p]
    measured_force: { column: scale, unit: gf, place_column: mm, place_unit: mm }
"""
RECORDING = """time: t
header: [t, a, b, c, d, p, scale, mm, base, turn]
length: 0.12
pause: 5
readings: [a, b, c, d]
pressures: { columns: [p], unit: kPa }
measured_force: { column: scale, unit: gf, place_column: mm, place_unit: mm }
frame: { origin: [0, 0, 0] }
"""
GRAM = 9.80665e-3  # N
LATE, ZERO, DRIFT = 0.4, 3.0, 6.0 / 60  # s, gf, gf/s
FORCES = {0.07: (0.3, 0.6, 0.45), 0.1: (0.25, 0.5, -0.3)}  # N, in the presses of a run, by the place, m
PERIOD, HOLD, RAMP = 0.02, 1.8, 0.2  # s


def write_log(folder: Path) -> Path:
    """Writes press.csv, its descriptions and scenario: ideal sensors, and a late, coarse scale that drifts."""
    for name, text in {"one.yaml": SCENARIO, "bench.yaml": BENCH, "scale.yaml": RECORDING}.items():
        (folder / name).write_text(text, encoding="utf-8")
    scenario = load_scenario(str(folder / "one.yaml"))
    (finger,) = add_plant(DiagramBuilder(), scenario, visuals=False).fingers
    gravity = complex(planar_gravity(finger.X_WB.GetAsMatrix34(), np.array(scenario.gravity)))
    layout = SensorLayout(finger.finger, 2, borders=(0.333,))
    rows, begins = [], 0.0
    for place, forces in FORCES.items():
        pressed = np.array([(0.0, 0.0), *((p, f) for force in forces for p, f in ((60e3, force), (0.0, 0.0)))])
        count = round(HOLD / PERIOD)
        share = np.clip(np.arange(count) * PERIOD / RAMP, 0, 1)[:, None]
        holds = [
            before + share * (after - before) for before, after in zip(pressed[[0, *range(6)]], pressed, strict=True)
        ]
        rows.append(_rows(layout, gravity, np.concatenate(holds), place, begins))
        begins = rows[-1][-1, 0] + 20.0
    np.savetxt(folder / "press.csv", np.vstack(rows), fmt="%.9g", delimiter=",")
    return folder / "press.csv"


def _rows(layout: SensorLayout, gravity: complex, driven: Array, place: float, begins: float) -> Array:
    """Rows of a run, of pressures and forces (T, 2)."""
    time, (pressure, force) = PERIOD * np.arange(len(driven)), driven.T
    found = {(p, f): in_balance(layout.finger, p, gravity, [Push(place, f)]) for p, f in {*map(tuple, driven.tolist())}}
    q = np.array([found[each] for each in map(tuple, driven.tolist())])
    shown = np.interp(time - LATE, time, force) / GRAM + ZERO + DRIFT * time
    readings = layout.read(q).reshape(len(q), -1)
    readings = readings + 1e-4 * np.random.default_rng(3).normal(size=readings.shape)
    joints = layout.finger.joint_arc_lengths < place
    lever = np.array([_moment(layout, each, place) for each in q])
    measured = np.column_stack([np.round(shown), np.full(len(q), 1e3 * place), force * lever, q[:, joints].sum(axis=1)])
    return np.column_stack([begins + time, readings, pressure / 1e3, measured])


def _moment(layout: SensorLayout, q: Array, place: float) -> float:
    """Of a force of 1 N that presses on the inner side, about the base."""
    ends = [*layout.finger.joint_arc_lengths[1:], layout.finger.length]
    lever, heading = layout.finger.segment_length / 2 + 0j, 0.0
    for angle, begin, end in zip(q, layout.finger.joint_arc_lengths, ends, strict=True):
        if begin < place:
            heading += angle
            lever += (min(end, place) - begin) * np.exp(1j * heading)
    return -float((lever * np.exp(-1j * heading)).real)
