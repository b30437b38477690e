"""A study over an analytic stand-in: its known optimum and front; the same table after an interruption; refusals."""

import numpy as np
import pytest
import yaml
from csv_rows import csv_rows
from here_executor import HereExecutor
from refusals import refused
from stand_in import FRICTION, GAIN, LENGTH, PRESSURE, WEIGHT, grasped

from soft_gripper.errors import InputError
from soft_gripper.extras.design.run_design import TABLE, most_runs, run_design
from soft_gripper.extras.design.study_file import load_design_study
from soft_gripper.extras.sweeps import scenario_runs
from soft_gripper.files.output import release_folders
from soft_gripper.models import DIRECTORY

STUDY = {
    "scenario": "bottle_grasp",
    "vary": {LENGTH: "0.10..0.14", PRESSURE: "20.0e3..160.0e3"},
    "draw": {FRICTION: "0.5..0.9"},
    "draws": 3,
    "test_draws": 20,
    "ends": [{"measure": "normal_force_n"}],
    "designs": 60,
}


@pytest.fixture(autouse=True, scope="module")
def _simulated():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(scenario_runs, "measured_runs", grasped)
        yield


@pytest.fixture(autouse=True)
def _unlocked():
    yield
    release_folders()


def study(folder, **changes):
    file = folder / "study.yaml"
    file.write_text(yaml.safe_dump(STUDY | changes, sort_keys=False))
    return load_design_study(file)


def designed(folder, out="out", executor=None, **changes):
    found = run_design(study(folder, **changes), folder / out, executor or HereExecutor())
    release_folders()
    return found


def compared_numbers(found):
    return list(dict.fromkeys(int(row["design"]) for row, _ in found.tests))


def rows(folder, out="out"):
    return csv_rows(folder / out / TABLE)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return designed(tmp_path_factory.mktemp("study"))


def test_the_known_optimum(found):
    """Least force holds with the least friction of the draws: F = weight / mu."""
    friction = min(float(row[FRICTION]) for row in rows(found.study.file.parent) if row["stage"] == "search")
    best = found.best
    optimum = WEIGHT / friction
    assert optimum <= best.ends[0] < 1.05 * optimum
    assert best.held == best.runs == 3


def test_it_is_tested_with_other_draws_beside_the_fingers_as_they_are_at_their_best_pressure(found):
    drawn = {stage: {row[FRICTION] for row in rows(found.study.file.parent) if row["stage"] == stage}
             for stage in ("search", "test")}  # fmt: skip
    assert (len(drawn["search"]), len(drawn["test"])) == (3, 20)
    assert drawn["search"].isdisjoint(drawn["test"])
    assert compared_numbers(found) == [found.reference.number, found.best.number]
    assert found.reference.values.keys() == {PRESSURE}
    optimum = WEIGHT / min(map(float, drawn["search"]))  # the stand-in holds with this force at any length
    assert optimum <= found.reference.ends[0] < min(1.05 * optimum, GAIN * 120e3 / 0.12)
    forces = [float(row["normal_force_n"]) for row, _ in found.tests[:20]]
    assert forces == [found.reference.ends[0]] * 20


def test_the_known_front(tmp_path):
    """Force against slip ratio: every pressure that holds is on the front, whose product is weight over friction."""
    ends = [{"measure": "normal_force_n"}, {"measure": "slip_ratio"}]
    found = designed(tmp_path, ends=ends, draw={}, designs=40)
    points = np.array([found.designs[i].ends for i in found.front])
    np.testing.assert_allclose(points.prod(axis=1), WEIGHT / 0.8, rtol=1e-6)
    allowed = [design for design in found.designs[1:] if design.is_allowed]
    assert len(found.front) == len(allowed) > 10
    assert np.ptp(points[:, 0]) > 0.5  # it is spread over them


class Interrupted(HereExecutor):
    """Is interrupted at a call."""

    def submit(self, work, /, *arguments):
        if len(self.calls) == 40:
            raise KeyboardInterrupt
        return super().submit(work, *arguments)


def test_an_interrupted_study_goes_on_to_the_same_table(tmp_path, found):
    with pytest.raises(KeyboardInterrupt):
        designed(tmp_path, executor=Interrupted())
    release_folders()
    executor = HereExecutor()
    again = run_design(study(tmp_path), tmp_path / "out", executor, resume=True)
    whole = rows(found.study.file.parent)
    assert rows(tmp_path) == whole
    assert len(executor.calls) < len(whole) - 20
    assert again.best == found.best


def test_thin_walls_are_refused_before_they_are_simulated(tmp_path):
    """A chamber 9 mm wide in a finger 20 mm wide leaves walls of 5.5 mm; of 9.8 mm thickness the outer is 4 mm."""
    key = "models.gripper.fingers.all.chamber_width"
    executor = HereExecutor()
    found = designed(
        tmp_path, executor=executor, wall=2e-3, vary={key: "6.0e-3..25.0e-3", PRESSURE: "60.0e3..160.0e3"}, designs=30
    )
    for design in found.designs[1:]:
        width = design.values[key]
        assert bool(design.refused) == (width > 16e-3)
        if 16e-3 < width < 19.9e-3:
            assert f"a wall of {1e3 * (20e-3 - width) / 2:.2f} mm, below 2 mm" in design.refused
    simulated = [float(row[key]) for row in rows(tmp_path) if int(row["design"]) > 0]
    assert max(simulated) <= 16e-3
    assert any(design.refused for design in found.designs)


def test_choices_and_whole_numbers(tmp_path):
    gripper = ["package://soft_gripper/grippers/two_finger.urdf", "package://soft_gripper/grippers/three_finger.urdf"]
    vary = {"models.gripper.file": gripper, "sensor.sections": "1..4", PRESSURE: "60.0e3..160.0e3"}
    found = designed(tmp_path, vary=vary, designs=24)
    assert {design.values["models.gripper.file"] for design in found.designs[1:]} == set(gripper)
    assert {design.values["sensor.sections"] for design in found.designs[1:]} == {1, 2, 3, 4}


def test_objects_of_the_users(tmp_path):
    (tmp_path / "can.obj").write_text((DIRECTORY / "objects/cylinder.obj").read_text())
    can = {"models.bottle.file": "can.obj", "models.bottle.X_PC.translation.2": 0.02, FRICTION: "0.3..0.4"}
    objects = {"bottle": {}, "can": can}
    found = designed(tmp_path, objects=objects, unseen={"sticky": {FRICTION: 0.95}}, designs=6)
    table = rows(tmp_path)
    assert all(0.3 <= float(row[FRICTION]) <= 0.4 for row in table if row["object"] == "can")
    assert {row["object"] for row in table if row["stage"] == "search"} == {"bottle", "can"}
    assert list(dict.fromkeys(row["object"] for row, _ in found.tests)) == ["bottle", "can", "sticky"]
    sticky = [int(row["design"]) for row, _ in found.tests if row["object"] == "sticky"]
    assert sticky == compared_numbers(found)  # once each: nothing is random


@pytest.mark.parametrize(
    ("changes", "field", "value"),
    [
        ({"vary": {}}, "vary", {}),
        ({"vary": {"sensor.sectoins": "1..4"}}, "sensor.sectoins", 1),
        ({"vary": {"sensor.sections": "4..1"}}, "vary.sensor.sections", "4..1"),
        ({"vary": {"sensor.sections": 3}}, "vary.sensor.sections", 3),
        ({"vary": {"sensor.sections": "0..4"}}, "sensor.sections", 0),
        ({"ends": []}, "ends", []),
        ({"draw": {FRICTION: 0.5}}, f"draw.{FRICTION}", 0.5),
        ({"draw": {FRICTION: "0.9..0.5"}}, f"draw.{FRICTION}", "0.9..0.5"),
        ({"objects": {"can": {FRICTION: "0.5..0.5"}}}, f"objects.can.{FRICTION}", "0.5..0.5"),
        ({"draw": {PRESSURE: "1.0..2.0"}}, f"draw.{PRESSURE}", "1.0..2.0"),
        ({"limits": {"slip_ratio": {}}}, "limits.slip_ratio.least", None),
        ({"limits": {"slip_ratio": {"least": 2.0, "most": 1.0}}}, "limits.slip_ratio.least", 2.0),
        ({"objects": {"a b": {}}}, "objects", "a b"),
        ({"unseen": {"as_in_the_scenario": {}}}, "unseen.as_in_the_scenario", "as_in_the_scenario"),
        ({"objects": {f"o{i}": {} for i in range(1001)}}, "objects", "1001 with unseen"),
        ({"scenario": "bottel"}, "name", "bottel"),
    ],
)
def test_a_wrong_study_names_field_and_value(tmp_path, changes, field, value):
    with refused(field) as caught:
        study(tmp_path, **changes)
    assert value is None or caught.value.value == value
    assert "study.yaml" in str(caught.value)


def test_a_measure_that_always_fails_ends_the_study_before_the_search(tmp_path, monkeypatch):
    def failing(scenario, changes, own):
        raise InputError("design", "estimator.type", "arcs", "reports no contact force")

    monkeypatch.setattr(scenario_runs, "measured_runs", failing)
    executor = HereExecutor()
    with refused("scenario", "bottle_grasp") as caught:
        run_design(study(tmp_path), tmp_path / "out", executor)
    assert "every run of it fails: design: estimator.type = 'arcs': reports no contact force" in str(caught.value)
    assert len(executor.calls) == 3


HOSTILE = [
    None,
    True,
    -1,
    1e300,
    float("nan"),
    "x",
    "1..",
    "..",
    "1..2 %",
    "-1e9..1e9",
    [],
    [1],
    {},
    {"a": 1},
    [[], {}],
    "é",
]


@pytest.mark.parametrize("key", [*STUDY, "set", "objects", "unseen", "wall", "limits", "batch", "seed"])
def test_hostile_values_are_taken_or_refused(tmp_path, key):
    """Nothing but an InputError, whatever stands in place of a field or of what lies in it."""
    for value in HOSTILE:
        for hostile in (value, [value], {"sensor.sections": value}, {"bottle": {"models.bottle.mass": value}}):
            assert "study.yaml" in complaint(tmp_path, **{key: hostile})


def complaint(folder, **changes):
    """Why a study is refused; its file if it is not."""
    try:
        return str(study(folder, **changes).file)
    except InputError as error:
        return str(error)


@pytest.mark.parametrize("vary", [STUDY["vary"], {LENGTH: "0.10..0.14"}], ids=["drive", "fingers alone"])
def test_a_study_is_as_long_as_it_says(tmp_path, vary):
    """Runs of the fingers as they are, of every design of both searches, and of the two that are tested."""
    found = designed(tmp_path, vary=vary, designs=6)
    assert not any(design.refused for design in found.designs)
    assert len(compared_numbers(found)) == 2
    assert len(rows(tmp_path)) == most_runs(found.study)
