"""Fingers of which a fifth of the settled bend comes slowly: what their estimators make of it, knowing it or not."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from creeping_fingers import FINGER, GRIPPER, write_creeping
from finger_plants import free_bending

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.fingers.creep import advance
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

SHARE, TIME = 0.2, 0.4  # s
PERIOD = 0.01  # s
FINGERS = ("left_finger", "right_finger")
LIMIT = 0.65  # N, of the closing force
GRIP = (
    *("control.set_points=[0.03]", "control.hold=2.5", f"control.force_limit={LIMIT}"),
    *("control.force_gains={kp: 2.0e4, ki: 4.0e5}", "control.gains={kp: 1.0e5, ki: 5.7e6, kd: 17}"),
    *("pressure.minimum=-40e3", "pressure.maximum=210e3", "estimator.type=contact", "sensor.sections=2"),
)
CONTACT = "estimator.contact_threshold=2.5e-3"
AWARE, UNAWARE = "nominal.creep=true", "nominal.creep=false"


def values(recording: Recording, signal: str, begin: float) -> np.ndarray:
    """A signal of both fingers from a time on, s, (2, T, ...)."""
    return np.array([recording[f"{finger}.{signal}"].sel(time=slice(begin, None)) for finger in FINGERS])


def closing(recording: Recording, kind: str, begin: float) -> np.ndarray:
    """The true or the estimated closing force likewise, (2, T) N."""
    return recording.forces().data[kind].sel(time=slice(begin, None)).values.T


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Steps of the pressure in free air, by an estimator that knows of creep."""
    file = write_creeping(FINGER, tmp_path_factory.mktemp("free"), SHARE, TIME)
    plant = [*(f"models.{i}.file={file}" for i in range(2)), "estimator.type=gaussian", "sensor.sections=2", CONTACT]
    return simulate(free_bending([60e3, 150e3, 0.0, 90e3], 0.8, *plant, AWARE))


@pytest.fixture(scope="module")
def grip(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A box held with a limited force."""
    plant = f"models.0.file={write_creeping(GRIPPER, tmp_path_factory.mktemp('grip'), SHARE, TIME)}"
    return simulate(load_scenario("box_grasp", [plant, *GRIP, CONTACT, AWARE]))


def test_in_free_air_creep_is_no_contact(free: Recording) -> None:
    """Nor a torque: what is left is what steps leave of a finger that does not creep."""
    assert not values(free, "contact", 0.0).any()
    assert np.abs(values(free, "external_torque", 3.0)).max() < 1e-3
    assert values(free, "pose_error", 3.0).max() < 1e-5


_REALISTIC = (
    *("sensor.errors.preset=realistic", "sensor.sections=2", "estimator.type=recursive", "nominal.creep=false"),
    "estimator.contact_threshold=8.5e-3",
)
_ASSUMED = "reading: 2.0e-3, bend_per_pressure: 0.03, pressure: 500.0, gain: 0.01, offset: 1.0e-3, drift: 3.0e-4"


def assuming(creep: float) -> tuple[str, ...]:
    """Realistic sensors, and an estimator that assumes so much creep beyond its model."""
    return (*_REALISTIC, f"estimator.uncertainty={{{_ASSUMED}, creep: {creep}}}")


@pytest.mark.parametrize(("creep", "least", "most"), [(0.0, 0.40, 0.60), (0.2, 0.0, 0.08)])
def test_recursive_follows_creep_that_it_does_not_know(tmp_path: Path, creep: float, least: float, most: float) -> None:
    """Of samples in free air, as docs/estimators.md states."""
    files = [f"models.{i}.file={write_creeping(FINGER, tmp_path, SHARE, 2.0)}" for i in range(2)]
    steps = [-30e3, 0.0, 50e3, 100e3, 150e3, 60e3]
    run = simulate(free_bending(steps, 3.0, *files, *assuming(creep)))
    assert least <= np.nanmean(values(run, "contact", 0.0) > 0) <= most


def test_true_contacts_are_still_detected(tmp_path: Path) -> None:
    """Within 0.1 s, and for as long as they last."""
    gripper = f"models.0.file={write_creeping(GRIPPER, tmp_path, SHARE, 2.0)}"
    run = simulate(load_scenario("box_grasp", [gripper, *assuming(0.2)]))
    touched = np.abs(values(run, "true_contact_force", 0.0)) > 0.02
    for true, loaded in zip(touched, values(run, "loaded", 0.0), strict=True):
        begin = int(true.argmax())
        assert not loaded[:begin].any()  # of a hanging finger, before it closes
        assert loaded[begin + round(0.1 / PERIOD) :][true[begin + round(0.1 / PERIOD) :]].all()


def stated(row: str) -> list[float]:
    """The numbers of a row of the page: without creep, with creep that is modelled, and not."""
    page = (Path(__file__).parents[2] / "docs" / "estimators.md").read_text(encoding="utf-8")
    (line,) = (line for line in page.splitlines() if line.startswith(f"| {row}"))
    return [float(cell.strip(" %")) for cell in line.split("|")[2:-1]]


@pytest.mark.published
def test_the_page_states_what_creep_costs(tmp_path: Path) -> None:
    """An exact model but for creep, ideal sensors: the force on a held box, and false contacts in free air, %."""
    gripper = f"models.0.file={write_creeping(GRIPPER, tmp_path, SHARE, 2.0)}"
    finger = write_creeping(FINGER, tmp_path, SHARE, 2.0)
    exact = [CONTACT, "sensor.sections=2", "estimator.uncertainty.bend_per_pressure=0.005"]
    held = ["estimator.type=contact", "pressure.steps.all=[100e3]", "pressure.settle=9.9", "pressure.hold_samples=10"]
    errors, false = [], []
    for who in (None, AWARE, UNAWARE):
        box = simulate(load_scenario("box_grasp", [*exact, *held, *([gripper, who] if who else [])]))
        force, true = (np.abs(values(box, name, 9.9)).mean() for name in ("contact_force", "true_contact_force"))
        errors.append(100 * (force / true - 1))
        creeping = [*(f"models.{i}.file={finger}" for i in range(2)), who] if who else []
        free = free_bending([-30e3, 0.0, 50e3, 100e3, 150e3, 60e3], 3.0, *exact, "estimator.type=recursive", *creeping)
        false.append(100 * np.nanmean(values(simulate(free), "contact", 0.0) > 0))
    np.testing.assert_allclose(errors, stated("box held for 10 s: error of the contact force"), atol=0.6)
    np.testing.assert_allclose(false, stated("free air: samples with a false contact, `recursive`"), atol=0.6)


def test_memory_is_that_of_the_true_angles(free: Recording, shipped_finger: Finger) -> None:
    """As they are linear between samples; the block holds what is estimated, for half a sample too long in the mean."""
    q, driving = (values(free, name, 0.0)[0, 1:] for name in ("sampled_joint_angles", "driving_torque"))
    pressure, branches = values(free, "sampled_pressure", 0.0)[0, 1:], (CreepBranch(SHARE, TIME),)
    z = [np.zeros((1, 12))]
    for before, after in pairwise(q):
        z.append(advance(branches, z[-1], before, after, PERIOD))
    memory = SHARE * shipped_finger.stiffness * np.array(z)[:, 0]
    np.testing.assert_allclose(driving - shipped_finger.pressure_torque(pressure), memory, atol=0.02 * memory.max())
    assert memory.max() > 0.02


def test_a_grip_keeps_its_force(grip: Recording) -> None:
    """Within 2 % from the first second on, though the fingers creep all the while; contact is kept."""
    force = closing(grip, "true_closing", 1.2)
    assert np.ptp(force) < 0.02 * force.mean()
    assert force.mean() == pytest.approx(LIMIT, rel=0.06)
    assert values(grip, "contact", 0.5).all()
    assert np.ptp(values(grip, "sampled_pressure", 1.2)) > 300
