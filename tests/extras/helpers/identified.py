"""Recordings whose truth is known: fingers of few segments, simulated, as arrays and as files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from hardware_files import OF_TIP, write_csv

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.simulated_motion import MeasuredMotion, Setup, simulated_markers
from soft_gripper.fingers.finger import Finger

REFERENCE = np.array([0.1 + 0.01j, 0.1 - 0.015j, 0.095 + 0.012j])  # m, z + i x of the markers while it is straight
RELEASE, LET_GO, OPENS, CLOSES = 0.35, 0.38, 0.35, 1.2  # s
NOISE = 1e-5  # m, standard deviation
SECTION = 'width="0.03" thickness="0.03"'
BEAM = f"""<?xml version="1.0"?>
<robot name="r">
  <!-- a first guess -->
  <link name="clamp"/>
  <frame name="fingers: load with soft_gripper.add_fingers, or soft-gripper expand"/>
  <finger name="beam">
    <parent link="clamp"/>
    <body length="0.1" segments="4" relaxation_time="0.01"/>
    <base {SECTION} material="dragon_skin_10"/>
    <tip {SECTION} material="dragon_skin_10"/>
    <sensors spacing="0.02"/>
    <creep share="0.2" time="0.2"/>
  </finger>
</robot>
"""
HOLLOW = BEAM.replace(SECTION, f'{SECTION} chamber_width="0.012" chamber_thickness="0.008" chamber_center="-0.006"')
DESCRIPTION = OF_TIP + "gravity: [9.81, 0, 0]\nreference: 0.3\n"
RELEASED = DESCRIPTION + "event: release\n"
STEPPED = DESCRIPTION + "event: step\ncommanded_pressure: [{pattern: '{number}kPa', unit: kPa}]\n"


def finger_of(text: str, folder: Path) -> Finger:
    """The finger of a file's text."""
    file = folder / "finger.urdf"
    file.write_text(text, encoding="utf-8")
    return read_finger(file)


def release(duration: float = 1.6, gravity: float = 9.81) -> MeasuredMotion:
    """A hand lets go of a horizontal finger; its markers are yet where they were."""
    time = np.arange(0, duration, 0.01)
    markers, down = np.tile(REFERENCE, (len(time), 1)), np.array([gravity, 0.0, 0.0])
    return MeasuredMotion("released", time, markers, REFERENCE, down, None, None, (RELEASE, LET_GO))


def step(pressure: float, duration: float = 1.6) -> MeasuredMotion:
    """A chamber is filled and emptied; its markers are yet where they were."""
    return replace(release(duration), name=f"{pressure / 1e3:.0f}kPa", pressure=pressure, events=(OPENS, CLOSES))


def recorded(finger: Finger, motion: MeasuredMotion, setup: Setup | None = None, seed: int = 0) -> MeasuredMotion:
    """The motion of a finger as markers show it, with noise."""
    noise = np.random.default_rng(seed).normal(0, NOISE, (2, *motion.markers.shape))
    markers = simulated_markers(finger, setup or Setup(), motion) + noise[0] + 1j * noise[1]
    return replace(motion, markers=markers)


def motion_columns(time: Array, markers: Planar) -> dict[str, Array]:
    """Columns of a recording of markers, in the way that DESCRIPTION says, mm and s."""
    columns = {"time_s": time}
    for i, marker in enumerate(markers.T):
        for axis, values in (("x", marker.imag), ("y", 0 * time), ("z", marker.real)):
            columns[f"tip_{i + 1}_{axis}_mm"] = 1e3 * values
    return columns


def write_motion(path: Path, time: Array, markers: Planar) -> Path:
    """The file that motion capture would leave of markers."""
    return write_csv(path, motion_columns(time, markers))
