"""Many grasps: those of processes that die, models and tables from them, and the shipped model."""

from dataclasses import asdict

import numpy as np
import pytest
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError, WorkerDiedError
from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.extras.recognition import random_grasps
from soft_gripper.extras.recognition.object_classifier import load_object_classifier
from soft_gripper.extras.recognition.random_grasps import (
    DRAWS,
    SECTIONS,
    SHAPES,
    Grasp,
    GraspRow,
    Probe,
    check_scenario_for_recognition,
    confusion,
    confusion_figure,
    draw,
    grasp_row,
    left_out,
    probe,
    recognized,
    run_grasps,
    train,
    with_object,
)
from soft_gripper.scenario.scenario_file import load_scenario

NUMBERS = {"train": 10, "test": 5}
FAILED = ("test", 2, "box")
SETS_OF_SENSORS = 2


def simulated(file, seed, set, number, shape):
    """In the place of a grasp that runs: probes that differ by shape and scatter a little."""
    drawn = draw(seed, set, number, shape)
    if (set, number, shape) == FAILED:
        raise InputError("grasp", "contact", 1, "began inside")
    rng = np.random.default_rng([seed, len(set), number, *shape.encode()])
    center = np.random.default_rng([*shape.encode()]).normal(size=(2, 1, 3, 2, 12))
    probes = {n: Probe(*(center + 0.1 * rng.normal(size=(2, SETS_OF_SENSORS, 3, 2, 12)))) for n in SECTIONS}
    return Grasp(set, number, shape, drawn, probes)


@pytest.fixture
def grasps(monkeypatch):
    """Grasps made here; the process of one dies."""
    dead = ("probing_grasp", 1, "train", 3, "sphere")

    def run(*call):
        if call == dead:
            raise WorkerDiedError("its process died")
        return simulated(*call)

    monkeypatch.setattr(random_grasps, "run_grasp", run)
    reported = []
    found = run_grasps("probing_grasp", NUMBERS, 1, HereExecutor(), lambda: reported.append(1))
    assert len(reported) == len(found)
    return found


def test_grasps_come_in_order_and_those_that_were_lost_have_a_cause(grasps):
    expected = [(set, i, shape) for set, number in NUMBERS.items() for i in range(number) for shape in SHAPES]
    assert [(grasp.set, grasp.number, grasp.shape) for grasp in grasps] == expected
    causes = {(grasp.set, grasp.number, grasp.shape): grasp.cause for grasp in grasps if grasp.cause}
    assert causes == {("train", 3, "sphere"): "its process died", FAILED: "grasp: contact = 1: began inside"}


@pytest.mark.slow
def test_a_grasp_that_failed_counts_as_not_recognized(grasps):
    models = {sections: train("probing_grasp", grasps, sections) for sections in SECTIONS}
    rows = [grasp_row(grasp, models) for grasp in grasps]
    for sections in SECTIONS:
        assert models[sections].sections == sections
        found = confusion(rows, sections)
        np.testing.assert_allclose(found.sum(axis=1), [5, 5, 4, 5])
        np.testing.assert_array_equal(found[:, :-1] - np.diag(np.diag(found)), 0)  # of another shape none
        assert found[:, -1].sum() <= 4  # known ones that count as unknown
    (failed,) = (row for row in rows if (row.set, row.grasp, row.shape) == FAILED)
    assert (failed.recognized_2, failed.recognized_4, failed.cause) == ("", "", "grasp: contact = 1: began inside")


def test_rows_of_the_confusion_are_what_is_held_and_columns_what_is_recognized():
    """Of test grasps alone: a sphere that passes for a box, once and a half, as one set of sensors finds it unknown."""
    drawn = RandomObject(0.0, 0.0, 0.0, 40.0, 0.7, 1.0)
    pairs = [
        *(("test", "sphere", "box box"), ("test", "sphere", "box unknown")),
        *(("test", "box", "box box"), ("train", "box", "sphere sphere")),
    ]
    rows = [
        GraspRow(set, i, held, **asdict(drawn), recognized_2=found, recognized_4="", cause="")
        for i, (set, held, found) in enumerate(pairs)
    ]
    expected, names = np.zeros((4, 5)), list(SHAPES)
    expected[names.index("sphere"), names.index("box")] = 1.5
    expected[names.index("sphere"), -1] = 0.5
    expected[names.index("box"), names.index("box")] = 1
    np.testing.assert_array_equal(confusion(rows, 2), expected)


def test_models_are_trained_with_the_training_grasps_alone(grasps):
    trained = train("probing_grasp", grasps, 4)
    alone = train("probing_grasp", [grasp for grasp in grasps if grasp.set == "train"], 4)
    np.testing.assert_array_equal(trained.means, alone.means)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ("sensor.pressure_errors={noise: 100}", "sensor.pressure_errors"),
        ("sensor.errors={dead: [{path: outer, section: 3}]}", "sensor.errors.dead"),
        ("pressure.hold_samples=4", "pressure.hold_samples"),
        ("sensor.errors.preset=realistic", ""),
    ],
)
def test_errors_of_sensors_that_cannot_be_made_again_are_refused(monkeypatch, change, field):
    changed = load_scenario("probing_grasp", [change])
    monkeypatch.setattr(random_grasps, "load_scenario", lambda file: changed)
    if not field:
        check_scenario_for_recognition("mine")
        return
    with pytest.raises(InputError) as error:
        check_scenario_for_recognition("mine")
    assert error.value.field == field


def test_a_shape_without_a_grasp_is_reported(grasps):
    with refused("grasps", ["grasp: contact = 1: began inside", "its process died"]):
        train("probing_grasp", [grasp for grasp in grasps if grasp.shape != "sphere" or grasp.cause], 4)


def test_the_figure_shows_every_count_and_the_share_that_is_right():
    matrices = {2: np.array([[3, 1, 0], [1, 0, 1.5]]), 4: np.array([[4, 0, 0], [1, 3, 0]])}
    figure = confusion_figure(["ball", "can"], matrices, 4)
    for axes, matrix, right in zip(figure.axes, matrices.values(), ("37.5", "87.5"), strict=True):
        assert f"{right} % right" in axes.get_title()
        assert [text.get_text() for text in axes.texts] == [f"{count:g}" for count in matrix.ravel()]
        np.testing.assert_allclose(axes.images[0].get_array(), matrix / 4)


def test_a_shape_that_was_left_out_is_unknown(grasps):
    found = left_out("probing_grasp", [grasp for grasp in grasps if grasp.probes], 4)
    assert found.keys() == set(SHAPES)
    assert min(found.values()) > 90


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["sphere", "cylinder", "irregular"])
def test_the_shipped_model_recognizes_a_grasp_that_it_has_not_seen(shape):
    """Trained for another finger or other pressures, it would not."""
    model = load_object_classifier("package://soft_gripper/grippers/two_finger_objects.json")
    scenario, drawn = load_scenario("probing_grasp"), RandomObject(2.0, 0.0, 12.0, 40.0, 0.7, 1.0)
    assert list(model.pressures) == scenario.pressure.steps["all"]
    station = make_station(with_object(scenario, shape, drawn))
    found = probe(station, run_station(station), model.sections, np.random.default_rng(0))
    answers = recognized(model, Grasp("test", 0, shape, drawn, {model.sections: found})).split()
    assert len(answers) == DRAWS
    assert answers.count(shape) > DRAWS / 2
