"""Fingers at rest in runs, by which sensors are judged: how they came there, and what touches them.

T samples of F fingers, of which K are held; D joint positions, way after way; C pressures.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.driving_torque import depends_on_bend, driving_torques
from soft_gripper.extras.hardware.recorded_run import RecordedRun, read_signal
from soft_gripper.extras.studies.contacts.contacts import Contacts, load_contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import held_rows, held_samples
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.sensors.measurement import ways_in_space
from soft_gripper.sensors.sensor_block import joints_port
from soft_gripper.truth.contact import touches


@dataclass(frozen=True, eq=False)
class Samples:
    """Fingers of a run at rest, M = K F samples, and the way to them."""

    run: str
    sensor: SensorConfig  # of the scenario; a design gives it other sections
    way: Array  # (T, F, D) joint positions
    pressures: Array  # (T, F, C) Pa
    tensions: Array | None  # (T, F, tendons) N
    held: NDArray[np.int_]  # (K), which of the T samples
    contacts: Contacts  # M, sample after sample; places are NaN where nothing touches, pressures are those above

    @property
    def finger(self) -> Finger:
        """The simulated finger."""
        return self.contacts.finger

    @property
    def touched(self) -> NDArray[np.bool_]:
        """Which of the samples are touched, (M)."""
        return np.isfinite(self.contacts.arc_length)

    def driving(self, nominal: Finger) -> Array:
        """Driving torque at the joints of a nominal finger, N m, and N where they slide, (M, D)."""
        held, torques = self.held, []
        for way in ways_in_space(nominal):
            if way == "bending" and depends_on_bend(nominal):
                bent = self.way[..., : nominal.segments]
                torques.append(driving_torques(nominal, bent, self.pressures[..., 0], self.sensor.period)[held])
            elif way in nominal.driven_ways:
                tensions = None if self.tensions is None else self.tensions[held]
                torques.append(nominal.torque_of_drive(way, self.pressures[held], tensions))
            else:
                torques.append(np.zeros((len(held), self.way.shape[1], nominal.segments)))
        torque = np.concatenate(torques, axis=-1)
        return torque.reshape(-1, torque.shape[-1])


def held_fingers(name: str, run: RecordedRun) -> list[Samples]:
    """The fingers of a run that touch something at any held step; all of them if none does.

    `name` is that of the scenario or the file.

    Raises:
        InputError: if a signal was not recorded, or the recording ends before the scenario does.
    """
    lasts, duration = float(run.recording["time"][-1]), run.scenario.duration
    if lasts < duration - 1.5 * run.scenario.sensor.period:
        raise InputError(name, "time", lasts, f"the recording ends before the steps of its scenario, {duration:g} s")
    touched = [finger for finger in run.fingers if _touches_anything(name, run, finger)]
    return [_held_finger(name, run, finger) for finger in touched or run.fingers]


def _touches_anything(name: str, run: RecordedRun, finger: PlantFinger) -> bool:
    force = read_signal(name, run.recording, f"{finger.name}.link_contact_force", finger.finger.segments + 1)
    return bool(touches(held_samples(run.scenario, run.recording, force).mean(axis=1)).any())


def _held_finger(name: str, run: RecordedRun, plant_finger: PlantFinger) -> Samples:
    scenario, recording, finger = run.scenario, run.recording, plant_finger.finger
    held, others = held_rows(scenario, recording)[:, -1], ways_in_space(finger)[1:]

    def of(signal: str, *shape: int) -> Array:
        return read_signal(name, recording, f"{plant_finger.name}.{signal}", *shape)

    def touch(signal: str, *shape: int) -> Array:  # NaN where nothing touches
        values = read_signal(name, recording, f"{plant_finger.name}.{signal}", *shape, allow_nan=True)
        return values[held]

    def effort(kind: str, size: int) -> Array:
        return of(f"sampled_{kind}", *([size] if size > 1 else [])).reshape(-1, 1, size)

    positions = ["sampled_joint_angles", *(f"true_{joints_port(way)}" for way in others)]
    way = np.concatenate([of(signal, finger.segments) for signal in positions], axis=-1)[:, None]
    R_BW = np.swapaxes(of("X_WB", 3, 4)[held][..., :3], -1, -2)
    # Of a finger that leaves its plane, what presses on it; in the plane, what presses across it.
    across, none = np.abs(touch("normal_force" if others else "true_contact_force")), np.zeros(len(held))
    contacts = Contacts(
        finger,
        q=way[held, 0],
        pressure=none,
        gravity=R_BW @ np.array(scenario.gravity),
        normal_force=across,
        force=(R_BW @ touch("true_contact_force_world", 3)[..., None])[..., 0],
        torque=np.zeros_like(way[held, 0]),
        arc_length=np.where(touches(across), touch("true_contact_arc_length"), np.nan),
        side=touch("true_contact_side"),
        friction=none,
    )
    pressures = effort("pressure", finger.pressures) if finger.pressures else np.zeros((len(way), 1, 0))
    tensions = effort("tension", len(finger.tendons)) if finger.tendons else None
    return Samples(name, scenario.sensor, way, pressures, tensions, held, contacts)


def single_contacts(file: Path, sensor: SensorConfig) -> Samples:
    """Single contacts, each read once, by sensors such as those of a scenario."""
    contacts = load_contacts(file)
    return Samples(file.stem, sensor, contacts.q[None], contacts.pressure[None, :, None], None, np.array([0]), contacts)
