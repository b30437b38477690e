"""The tasks and our models on synthetic twins of the recordings, which independent scripts made up."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from synthetic_hardware import write_arm, write_beam, write_segment

from soft_gripper.errors import SimulationDivergedError
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.settled_states import (
    SettledStates,
    predicted_markers,
    resting_positions,
)
from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.scenario.model_files import model_path
from studies.benchmark import ours_recorded
from studies.benchmark.baselines import baselines
from studies.benchmark.benchmark_task import Part, read_tests, read_training, region_inputs
from studies.benchmark.estimates import answers
from studies.benchmark.ours import ours
from studies.benchmark.scores import scores as scores_of
from studies.benchmark.tasks import TASKS

TASK = {task.name: task for task in TASKS}


def twin(name, folder, **changes):
    """The task of a name, with the checksums of other files."""
    task = replace(TASK[name], **changes)
    digests = {file: hashlib.sha256((folder / file).read_bytes()).hexdigest() for file in task.sha256}
    return replace(task, sha256=digests)


def scores(task, folder, *names):
    train, tested = read_training(task, folder, folder / "copies"), read_tests(task, folder)
    estimators = baselines(task.question) | ours(task)
    stated = {name: answers(task.question, name, estimators[name], train, region_inputs(tested)) for name in names}
    rows = [row for name in names for row in scores_of(task, name, stated[name], tested)]
    return {(row.region, row.estimator): row for row in rows}


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    write_beam(folder / "clamped_beam", duration=6.0)
    return folder


def test_the_tip_of_a_beam_follows_from_its_turn(beam):
    """A load on the tip bends the beam other than an arc: the error of the arc is that of its shape."""
    found = scores(twin("beam_tip", beam), beam, "arcs", "gaussian", "recursive")
    assert found["at rest", "gaussian"].mean < 1e-3
    assert found["at rest", "gaussian"].mean < 0.5 * found["at rest", "arcs"].mean
    assert found["at rest", "recursive"].mean < 2e-3


def test_the_load_of_a_beam_is_weighed(beam):
    found = scores(twin("beam_load", beam), beam, "fitted", "ridge")
    assert found["102 g", "fitted"].mean < 5  # g
    assert found["102 g", "fitted"].mean < 0.2 * found["102 g", "ridge"].mean


@pytest.fixture(scope="module")
def segment(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    write_segment(folder / "pneumatic_segment", pressures=(10, 15, 20, 25, 35, 40, 45))
    return folder


def test_a_segment_bends_as_its_pressure_law_says(segment):
    found = scores(twin("segment_tip", segment), segment, "fitted", "nearest")
    for region in ("15 kPa", "20 kPa", "35 kPa", "40 kPa"):
        recorded = TASK["segment_tip"].read(segment / f"pneumatic_segment/{region.replace(' ', '')}.csv")
        travel = np.linalg.norm(np.ptp(recorded.outputs, axis=0))
        assert found[region, "fitted"].mean < 0.1 * travel  # inertia and the valve, which it leaves out, are the rest
        assert found[region, "fitted"].mean < found[region, "nearest"].mean


@pytest.mark.slow
def test_the_tip_of_an_arm_is_estimated_from_its_wires(tmp_path):
    write_arm(tmp_path / "two_segment_arm", duration=6.0)
    names = [f"two_segment_arm/trial_{trial}.txt" for trial in range(1, 6)]
    tested = {"S-shapes": (Part(names[1]), Part(names[3]))}
    trained = tuple(map(Part, names[::2]))
    task = twin(
        "arm_tip",
        tmp_path,
        sha256=dict.fromkeys(names),
        trained=trained,
        given=tuple(names[::2]),
        tested=tested,
        period=1 / 30,
    )
    found = scores(task, tmp_path, "arcs", "nearest")
    assert found["S-shapes", "arcs"].mean < 6e-3
    assert found["S-shapes", "arcs"].mean < 0.3 * found["S-shapes", "nearest"].mean
    assert found["S-shapes", "arcs"].within_band_percent > 80  # opposite bends were not trained on


def rested(description, pulled, at, load=0.0, gravity=(0.0, 0.0, 0.0), beyond=0.0):
    """Markers in B of the shipped finger with stiffer tendons, at rest, (R, M, 3) m."""
    finger = read_finger(model_path(f"package://soft_gripper/recordings/{description}.urdf"))
    tendons = tuple(replace(tendon, stiffness=1.3 * tendon.stiffness) for tendon in finger.tendons)
    finger = replace(finger, tendons=tendons)
    places = np.array([[0.0, 0.0, beyond]] * len(at))
    nothing = np.zeros((len(pulled), len(at), 3))
    states = SettledStates("", pulled, nothing, places, np.array([]), np.array(gravity), np.array(at), load)
    return predicted_markers(finger, states, resting_positions(Model(finger), states))[0]


FINGER = "package://soft_gripper/recordings/trunk_dc.urdf"
TRUNK_AT = [0.345, 0.64, 1.0]


@pytest.fixture(scope="module")
def trunk(tmp_path_factory):
    """Recordings of 100 rows of the same commands, in the axes of the file: it hangs along -y."""
    folder = tmp_path_factory.mktemp("data")
    random = np.random.default_rng(2)
    pulled_in = random.uniform(-0.012, 0.012, (100, 6))  # m
    for description, name, masses in (
        ("soft_trunk", "random", (0, 100, 300)),
        ("trunk_dc", "observations", (200, 400)),
    ):
        (folder / description).mkdir()
        radius = load_description(description).tendons.radius
        for mass in masses:
            turned = np.degrees(pulled_in / radius) + random.normal(0, 1, pulled_in.shape)
            pulled = np.radians(np.hstack([turned, -turned])) * radius  # each motor winds two tendons
            markers = rested(description, pulled, TRUNK_AT, 1e-3 * mass, (0.0, 0.0, 9.81))
            x, y, z = np.moveaxis(markers, -1, 0)
            disks = np.stack([0.1 + x, -z, 0.105 + y], axis=-1) + random.normal(0, 1e-4, markers.shape)
            columns = [np.arange(100)[:, None], disks.reshape(100, 9), turned]
            table = np.hstack(columns if description == "soft_trunk" else [columns[0], *columns[:0:-1]])
            file = folder / description / f"{name}_{mass}g.csv"
            np.savetxt(file, table, delimiter=",", header="ID", comments="")
    return folder


@pytest.mark.published
@pytest.mark.parametrize(
    ("name", "file"),
    [("trunk_shape", "soft_trunk/random_0g.csv"), ("trunk_dc_shape", "trunk_dc/observations_200g.csv")],
)
def test_the_shape_of_a_trunk(trunk, monkeypatch, name, file):
    """Under the load that it was trained with."""
    monkeypatch.setattr(ours_recorded, "_FITTED_ROWS", 20)
    found = scores(twin(name, trunk, tested={"alike": (Part(file, 0.85),)}), trunk, "fitted", "ridge")
    assert found["alike", "fitted"].mean < 2e-3
    assert found["alike", "fitted"].mean < found["alike", "ridge"].mean


def test_the_load_of_a_window_is_that_which_agrees_best():
    random = np.random.default_rng(4)
    slope, curving = random.normal(size=(40, 3, 3)), 0.2 * random.normal(size=(40, 3, 3))
    for u in (-1.0, 0.3):
        found = ours_recorded._best_load_shift(slope * u + curving * u**2, slope, curving)
        assert found[5:] == pytest.approx(u, abs=1e-12)


@pytest.mark.published
def test_the_load_of_a_trunk_is_weighed(trunk, monkeypatch):
    monkeypatch.setattr(ours_recorded, "_LOAD_STRIDE", 6)
    monkeypatch.setattr(ours_recorded, "_WEIGHED", 2)
    found = scores(twin("trunk_load", trunk), trunk, "fitted")
    assert all(row.mean < 15 for row in found.values())  # g


def test_rows_without_a_balance_hold_the_one_before(monkeypatch):
    found = np.array([np.nan, 1.0, np.nan, np.nan, 2.0, np.nan])[:, None, None]
    monkeypatch.setattr(ours_recorded, "resting_positions", lambda model, states: None)
    monkeypatch.setattr(ours_recorded, "predicted_markers", lambda finger, states, q: (found, None))
    held = ours_recorded._markers(Model(read_finger(model_path(FINGER))), None)
    assert held.ravel().tolist() == [1, 1, 1, 1, 2, 2]
    found[:] = np.nan
    with pytest.raises(SimulationDivergedError):
        ours_recorded._markers(Model(read_finger(model_path(FINGER))), None)


@pytest.mark.parametrize(("name", "description"), [("trunk_shape", "soft_trunk"), ("trunk_dc_shape", "trunk_dc")])
def test_channels_of_the_trunk_have_the_names_of_the_recorded_columns(name, description):
    described = load_description(description)
    markers = [marker for markers in described.markers.bodies.values() for marker in markers]
    disks = [described.markers.columns.format(axis=axis, marker=marker) for marker in markers for axis in "xyz"]
    task = TASK[name]
    assert [channel.name for channel in task.outputs] == disks
    assert [channel.name for channel in task.inputs] == list(described.tendons.columns.values())
