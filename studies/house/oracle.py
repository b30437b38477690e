"""What the shipped scenarios and contacts give, stored before a change of the code and compared after it.

Every shipped scenario runs with `contact`, `gaussian` and `recursive`; the shipped test contacts are estimated one by
one. Lengths may differ by LENGTH, forces by FORCE; what differs by more is listed, and is either a fault or has to be
explained. NaN, for what is not known, must stay NaN. Tables that are published: `make release-check`.
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
from soft_gripper.fingers.kinematics import in_plane, in_space
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names
from studies.benchmark.contacts import FOLDER, layout

LENGTH, FORCE = 0.05e-3, 0.02  # m, N
EVERY = 10  # samples
ESTIMATORS = "contact", "gaussian", "recursive"
SIGNALS = {
    "true_tip_position": LENGTH,
    "true_contact_force": FORCE,
    "tip_pose": LENGTH,
    "estimated_tip_position": LENGTH,
    "position_std": LENGTH,
    "contact_force": FORCE,
    "contact_force_std": FORCE,
    "contact_force_interval": FORCE,
    "contact_force_bounds": FORCE,
    "contact_arc_length": LENGTH,
}
PARTS = "contact_force", "contact_arc_length", "force_interval", "force_bounds"


def values() -> Iterator[tuple[str, Array]]:
    """Every number of the oracle, by name."""
    yield from contacts()
    for name in tqdm(scenario_names(), unit="scenario"):
        for estimator in ESTIMATORS:
            yield from scenario_values(name, estimator)


def scenario_values(name: str, estimator: str) -> Iterator[tuple[str, Array]]:
    """The signals of a scenario, every EVERY samples; nothing of an estimator that it refuses."""
    own = load_scenario(name).estimator.type
    try:
        recording = simulate(load_scenario(name, [f"estimator.type={estimator}"]))
    except InputError as error:
        print(f"{name} refuses {estimator}: {error}", file=sys.stderr)
        return
    for signal in recording.data.data_vars:
        if str(signal).rpartition(".")[2] in SIGNALS:
            mark = " (its own)" if estimator == own else ""
            yield f"{name}/{estimator}{mark}/{signal}", recording.data[signal].values[::EVERY]


def contacts() -> Iterator[tuple[str, Array]]:
    """Forces, places and intervals of the contacts that the benchmark tests with."""
    rows = np.genfromtxt(FOLDER / "contacts_test.csv", delimiter=",", names=True)
    readings = np.stack([rows[f"reading_{i}"] for i in range(4)], axis=-1)
    gravity = in_space(in_plane(rows["gravity_x"], rows["gravity_z"]))
    for model, share in (("exact", EXACT), ("default", Uncertainty.bend_per_pressure)):
        shape = ContactShape(layout(), Uncertainty(reading=1.5e-3, bend_per_pressure=share))
        given = readings, layout().finger.pressure_torque(rows["pressure"]), gravity
        found, known = shape(*given).contact, shape.posterior(*given)
        assert found is not None
        parts = found.force, found.arc_length, known.force_interval, known.force_bounds
        for name, each in zip(PARTS, parts, strict=True):
            yield f"contacts/{model}/.{name}", each


def differences(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Largest difference, and what is allowed, of every number that is stored and found again.

    A number that was not stored is new, and left out.
    """
    stored = np.load(folder / "oracle.npz")
    for name, after in values():
        if name not in stored:
            continue
        before = stored[name]
        quantity = name.rpartition(".")[2]
        allowed = SIGNALS.get(quantity, FORCE)
        if before.shape != after.shape or (np.isfinite(before) != np.isfinite(after)).any():
            yield name, np.inf, allowed
        else:
            yield name, float(np.nanmax(np.abs(after - before), initial=0.0)), allowed


def run(options: argparse.Namespace) -> int:
    """Stores, or compares and prints what differs by more than allowed."""
    if options.action == "store":
        options.folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(options.folder / "oracle.npz", **cast(dict[str, Any], dict(values())))
        return 0
    found = list(differences(options.folder))
    worse = [(name, by, allowed) for name, by, allowed in found if not by <= allowed]
    for name, by, allowed in worse:
        print(f"{name}: differs by {by:.3g}, allowed {allowed:g}")
    print(f"{len(found)} signals, {len(worse)} differ by more than allowed")
    return int(bool(worse))
