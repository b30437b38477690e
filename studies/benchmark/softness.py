"""Recognizes the softness of a grasped block, of four materials, by the estimates of two fingers.

Two fingers close on a block, and press harder. The narrowest gap between their estimated inner surfaces becomes smaller
as the estimated force grows; the ratio is the compliance of the grasp. Some grasps train the compliances of a material,
the others are recognized by them. The shape is estimated by `gaussian` with an exact nominal model, from realistic
sensors, whose readings are averaged for two seconds at each pressure.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.uncertainty import EXACT
from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.extras.soft.adds import SoftMesh
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import results
from soft_gripper.files.row_table import write_csv
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.load.opening import Gripper, InnerSurface
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.runs.scores.readings import ReadAgain, external_torque_again, read_again
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import strain_errors
from studies.benchmark.random_objects import SENSOR_STREAM, SETS, disturb_readings, draw, free_model, replace_mesh

MATERIALS = {"20 kPa": 2e4, "60 kPa": 6e4, "200 kPa": 2e5, "wood": 1e8}  # Pa, moduli
_MIN_LISTED_PERCENT = 0.5  # %, of those that are listed
SECTIONS = (2, 4)
BLOCK = "package://soft_objects/objects/soft_block.vtk"
PRESSURES = [50e3, 200e3]  # Pa
_SCENARIO = "probing_grasp"
_CHANGES = (
    f"pressure.steps.all={PRESSURES}",
    "pressure.hold_samples=200",
    "plant_config.discrete_contact_approximation=sap",
    f"estimator.uncertainty.bend_per_pressure={EXACT}",
)
MAX_YAW, MAX_SIZE = 3.0, 10  # degrees, as poses are reported in grasp trials; percent
_ESTIMATOR = "gaussian"


def block_scenario(material: str, draw: RandomObject) -> Scenario:
    """Scenario of two fingers that close on a block, and press harder."""
    scenario = replace_mesh(load_scenario(_SCENARIO, _CHANGES), BLOCK, 1.0, draw)
    cast(SoftMesh, free_model(scenario).mesh).youngs_modulus = MATERIALS[material]
    return scenario


@dataclass(frozen=True)
class Compliance:
    """Estimated compliance in one grasp, m/N."""

    realistic: Array  # (E,) of each draw of the sensors
    ideal: float  # with ideal sensors


def grip_gaps(gripper: Gripper, fingers: Sequence[Finger], angles: Array, torques: Array) -> tuple[Array, Array]:
    """Narrowest gap between two fingers, and their normal force there.

    Args:
        gripper, fingers: the two.
        angles: of the joints, rad, (L, 2, N).
        torques: external ones, N m, (L, 2, N).

    Returns:
        gaps, (L,) m, and forces, (L,) N, the means of both fingers, by least squares over the joints; NaN at the base.
    """
    surfaces = [InnerSurface(finger) for finger in fingers]
    gaps, forces = np.empty(len(angles)), np.empty(len(angles))
    for level, (q, torque) in enumerate(zip(angles, torques, strict=True)):
        points = [surface.points(bends) for surface, bends in zip(surfaces, q, strict=True)]
        left_curve, right_curve = (gripper.curve(finger, bends) for finger, bends in enumerate(points))
        distances = np.linalg.norm(left_curve[:, None] - right_curve, axis=-1)
        closest = np.unravel_index(distances.argmin(), distances.shape)
        gaps[level] = distances[closest]
        finger_forces = []
        for finger, station in enumerate(closest):
            joints = forward_kinematics(q[finger], fingers[finger].segment_length).joints
            lever = np.maximum(points[finger][station].real - joints.real, 0)  # of a force across the base
            square = float(lever @ lever)
            finger_forces.append(-float(torque[finger] @ lever) / square if square > 0 else np.nan)
        forces[level] = np.mean(finger_forces)
    return gaps, forces


def compliance(gaps: Array, forces: Array) -> float:
    """Decrease of the gap over the increase of the force, from the first level to the last, m/N."""
    return float((gaps[0] - gaps[-1]) / (forces[-1] - forces[0]))


def grasp_compliance(seed: int, set: str, number: int, material: str) -> dict[int, Compliance]:
    """Simulates a grasp, and estimates its compliance for each number of sections."""
    station = make_private_station(block_scenario(material, draw(seed, set, number, material, MAX_YAW, MAX_SIZE)))
    recording = run_station(station)
    rng = np.random.default_rng([seed, SETS.index(set), number, *material.encode(), SENSOR_STREAM])
    return {sections: _compliance(station, recording, sections, rng) for sections in SECTIONS}


def _compliance(station: Station, recording: Recording, sections: int, rng: np.random.Generator) -> Compliance:
    errors = strain_errors(station.scenario.sensor)
    assert errors is not None
    ideal = [read_again(station, recording, finger, sections) for finger in station.fingers]
    draws = zip(*[disturb_readings(ideal_readings, errors, rng) for ideal_readings in ideal], strict=True)
    realistic = [_estimate_compliance(station, recording, draw) for draw in draws]
    return Compliance(np.array(realistic), _estimate_compliance(station, recording, ideal))


def _estimate_compliance(station: Station, recording: Recording, sensors: Sequence[ReadAgain]) -> float:
    """Estimates the compliance of a grasp from the readings of both fingers."""
    fingers = station.fingers
    angles: list[Array] = []
    torques: list[Array] = []
    for finger, readings in zip(fingers, sensors, strict=True):
        torque = external_torque_again(station, recording, finger, readings, _ESTIMATOR)
        for target, values in ((angles, readings.shape(_ESTIMATOR).q), (torques, torque)):
            target.append(held_samples(station.scenario, recording, values).mean(axis=1))
    gripper = Gripper.of_bases([finger.X_WB for finger in fingers])
    models = [finger.finger for finger in fingers]
    return compliance(*grip_gaps(gripper, models, np.stack(angles, axis=1), np.stack(torques, axis=1)))


def likeliest(compliances: Array, trained: dict[str, Array]) -> list[str]:
    """Most likely material of compliances, (E,), if those of every material are normally distributed."""
    names, means, widths = list(trained), *(np.array([f(v) for v in trained.values()]) for f in (np.mean, np.std))
    scores = -np.log(widths) - ((compliances[:, None] - means) / widths) ** 2 / 2
    return [names[i] for i in scores.argmax(axis=1)]


@dataclass(frozen=True)
class SoftnessRow:
    """Recognition of the test grasps of one material; each draw of sensors counts as a fraction of a grasp.

    compliance_mm_n, std_mm_n: mean and standard deviation.
    ideal_mm_n, ideal_std_mm_n: with ideal sensors.
    taken_for: recognized materials, in percent.
    """

    sections: int
    material: str
    grasps: int
    compliance_mm_n: float
    std_mm_n: float
    ideal_mm_n: float
    ideal_std_mm_n: float
    right_percent: float
    taken_for: str


Grasps = dict[tuple[str, int, str], dict[int, Compliance]]


def softness_row(grasps: Grasps, sections: int, material: str) -> SoftnessRow:
    """The row of a number of sections and a material."""
    trained = {name: _realistic(grasps, SETS[0], sections, name) for name in MATERIALS}
    test_grasps = _realistic(grasps, SETS[1], sections, material)
    ideal = [grasp[sections].ideal for (set, _, name), grasp in grasps.items() if (set, name) == (SETS[1], material)]
    answers = likeliest(test_grasps, trained)
    percentages = {name: 100 * answers.count(name) / len(answers) for name in MATERIALS}
    taken_for = ", ".join(f"{name} {share:.0f}" for name, share in percentages.items() if share >= _MIN_LISTED_PERCENT)
    return SoftnessRow(
        sections,
        material,
        len(ideal),
        compliance_mm_n=1e3 * float(test_grasps.mean()),
        std_mm_n=1e3 * float(test_grasps.std()),
        ideal_mm_n=1e3 * float(np.mean(ideal)),
        ideal_std_mm_n=1e3 * float(np.std(ideal)),
        right_percent=percentages[material],
        taken_for=taken_for,
    )


def _realistic(grasps: Grasps, set: str, sections: int, material: str) -> Array:
    """Estimated compliances of a material, m/N, with every draw of the sensors, (N,)."""
    draws = [grasp[sections].realistic for (part, _, name), grasp in grasps.items() if (part, name) == (set, material)]
    return np.concatenate(draws)


def print_softness(rows: Sequence[SoftnessRow]) -> None:
    """Prints the table."""
    print("sections  material  compliance [mm/N]  ideal sensors  right %  taken for %")
    for row in rows:
        real = f"{row.compliance_mm_n:.2f} +- {row.std_mm_n:.2f}"
        ideal = f"{row.ideal_mm_n:.2f} +- {row.ideal_std_mm_n:.2f}"
        print(f"{row.sections:8}  {row.material:<8} {real:>18} {ideal:>14} {row.right_percent:8.0f}  {row.taken_for}")
    for sections in SECTIONS:
        right_percent = np.mean([row.right_percent for row in rows if row.sections == sections])
        print(f"{sections} sections: {right_percent:.1f} % right")


def run(options: argparse.Namespace) -> None:
    """Runs the study, writes its table and prints it."""
    options.out.mkdir(parents=True, exist_ok=True)
    keys = [(set, i, material) for set in SETS for i in range(options.grasps) for material in MATERIALS]
    with open_executor(options.jobs, options.scheduler) as executor:
        grasps = results(executor, grasp_compliance, {key: (options.seed, *key) for key in keys})
    rows = [softness_row(grasps, sections, material) for sections in SECTIONS for material in MATERIALS]
    write_csv(options.out / "softness.csv", rows)
    print_softness(rows)
