"""Stores estimates of the shipped scenarios and contacts before a change of the code, and compares them after it.

Every shipped scenario runs with `contact`, `gaussian` and `recursive`; the shipped test contacts are estimated one by
one. Larger differences than LENGTH_TOLERANCE and FORCE_TOLERANCE are listed; each is either a fault or has to be
explained. NaN (unknown) must stay NaN. For published tables see `make release-check`. Another number is a `yield` of
`values`.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.fingers.kinematics import in_space, planar_vector
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names
from studies.benchmark.contacts import FOLDER, layout

LENGTH_TOLERANCE, FORCE_TOLERANCE = 0.05e-3, 0.02  # m, N
STRIDE = 10  # samples
ESTIMATORS = "contact", "gaussian", "recursive"
SIGNALS = {
    "true_tip_position": LENGTH_TOLERANCE,
    "true_contact_force": FORCE_TOLERANCE,
    "tip_pose": LENGTH_TOLERANCE,
    "estimated_tip_position": LENGTH_TOLERANCE,
    "position_std": LENGTH_TOLERANCE,
    "contact_force": FORCE_TOLERANCE,
    "contact_force_std": FORCE_TOLERANCE,
    "contact_force_interval": FORCE_TOLERANCE,
    "contact_force_bounds": FORCE_TOLERANCE,
    "contact_arc_length": LENGTH_TOLERANCE,
}
CONTACT_NUMBERS = "contact_force", "contact_arc_length", "force_interval", "force_bounds"


def values() -> Iterator[tuple[str, Array]]:
    """Yields every number of the oracle by its name."""
    yield from contacts()
    for name in tqdm(scenario_names(), unit="scenario"):
        for estimator in ESTIMATORS:
            yield from scenario_values(name, estimator)


def scenario_values(name: str, estimator: str) -> Iterator[tuple[str, Array]]:
    """Yields the signals of a scenario, every STRIDE samples; nothing if it refuses the estimator."""
    scenario_estimator = load_scenario(name).estimator.type
    try:
        recording = simulate(load_scenario(name, [f"estimator.type={estimator}"]))
    except InputError as error:
        print(f"{name} refuses {estimator}: {error}", file=sys.stderr)
        return
    for signal in recording.data.data_vars:
        if str(signal).rpartition(".")[2] in SIGNALS:
            mark = " (its own)" if estimator == scenario_estimator else ""
            yield f"{name}/{estimator}{mark}/{signal}", recording.data[signal].values[::STRIDE]


def contacts() -> Iterator[tuple[str, Array]]:
    """Yields forces, positions and intervals of the benchmark's test contacts."""
    rows = np.genfromtxt(FOLDER / "contacts_test.csv", delimiter=",", names=True)
    readings = np.stack([rows[f"reading_{i}"] for i in range(4)], axis=-1)
    gravity = in_space(planar_vector(rows["gravity_x"], rows["gravity_z"]))
    for model, bend_std in (("exact", EXACT), ("default", Uncertainty.bend_per_pressure)):
        shape = ContactShape(layout(), Uncertainty(reading=1.5e-3, bend_per_pressure=bend_std))
        inputs = readings, layout().finger.pressure_torque(rows["pressure"]), gravity
        contact, posterior = shape(*inputs).contact, shape.posterior(*inputs)
        assert contact is not None
        numbers = contact.force, contact.arc_length, posterior.force_interval, posterior.force_bounds
        for name, values_ in zip(CONTACT_NUMBERS, numbers, strict=True):
            yield f"contacts/{model}/.{name}", values_


def differences(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Yields the largest difference of every stored number, and the tolerance.

    New numbers, which are not stored, are left out.
    """
    stored_numbers = np.load(folder / "oracle.npz")
    for name, values_ in values():
        if name not in stored_numbers:
            continue
        stored_values = stored_numbers[name]
        quantity = name.rpartition(".")[2]
        tolerance = SIGNALS.get(quantity, FORCE_TOLERANCE)
        if stored_values.shape != values_.shape or (np.isfinite(stored_values) != np.isfinite(values_)).any():
            yield name, np.inf, tolerance
        else:
            yield name, float(np.nanmax(np.abs(values_ - stored_values), initial=0.0)), tolerance


def run(options: argparse.Namespace) -> int:
    """Stores, or compares and prints the numbers that differ by more than their tolerance."""
    if options.action == "store":
        options.folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(options.folder / "oracle.npz", **cast(dict[str, Any], dict(values())))
        return 0
    results = list(differences(options.folder))
    failures = [(name, difference, tolerance) for name, difference, tolerance in results if not difference <= tolerance]
    for name, difference, tolerance in failures:
        print(f"{name}: differs by {difference:.3g}, allowed {tolerance:g}")
    print(f"{len(results)} signals, {len(failures)} differ by more than allowed")
    return int(bool(failures))
