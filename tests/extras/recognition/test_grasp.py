"""Random grasps: what is drawn, where the object stands, and what is estimated of it, compared with the blocks."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.recording import add_logs, read_logs
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import add_station, make_station
from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.extras.recognition.object_classifier import ObjectClassifier
from soft_gripper.extras.recognition.random_grasps import (
    SHAPES,
    draw,
    free_model,
    lowest,
    probe,
    run_grasp,
    with_object,
)
from soft_gripper.extras.recognition.recognizer import SAMPLES, ObjectRecognizer
from soft_gripper.scenario.scenario_file import load_scenario

DRAWN = RandomObject(x_mm=2.0, y_mm=-3.0, yaw_deg=15.0, mass_g=25.0, friction=0.6, size=1.1)
NAMES = ("left_finger", "right_finger")


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("probing_grasp", ["sensor.errors=null"])


def test_what_is_drawn_follows_from_seed_set_number_and_shape_alone():
    cases = [(1, "train", 0, "box"), (1, "test", 0, "box"), (1, "train", 1, "box"), (1, "train", 0, "ball")]
    drawn = [draw(*case) for case in [*cases, (2, "train", 0, "box")]]
    assert len(set(drawn)) == 5
    assert draw(*cases[0]) == drawn[0]


def test_draws_fill_their_ranges_evenly():
    drawn = [draw(1, "train", i, "box") for i in range(1000)]
    for name, low, high in (("x_mm", -3, 3), ("yaw_deg", -20, 20), ("mass_g", 20, 60), ("size", 0.85, 1.15)):
        values = np.array([getattr(one, name) for one in drawn])
        assert low <= values.min() < low + 0.02 * (high - low)
        assert high - 0.02 * (high - low) < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, abs=0.05 * (high - low))


@pytest.mark.parametrize("shape", SHAPES)
def test_another_object_stands_as_high_as_that_of_the_scenario(scenario, shape):
    model = free_model(with_object(scenario, shape, DRAWN))
    X_WO = model.X_PC.GetDeterministicValue()
    foot = X_WO.translation()[2] + model.mesh.scale * lowest(model.file, X_WO.rotation())
    assert foot == pytest.approx(1e-5, abs=1e-9)
    np.testing.assert_allclose(X_WO.translation()[:2], [2e-3, -3e-3], atol=1e-12)
    assert np.degrees(RollPitchYaw(X_WO.rotation()).yaw_angle()) == pytest.approx(15.0)
    mesh = model.mesh
    scale = pytest.approx(1.1 * (0.7 if shape == "irregular" else 1.0))
    assert (mesh.scale, mesh.mass, mesh.friction) == (scale, pytest.approx(0.025), 0.6)
    assert free_model(scenario).file.endswith("box.obj"), "the scenario itself is left as it was"


def test_a_support_at_another_height_is_stood_on(scenario):
    box = free_model(scenario)
    raised = replace(box, X_PC=Transform(RigidTransform([0.1, 0.0, 0.23])))
    found = free_model(with_object(replace(scenario, models=[raised]), "sphere", DRAWN))
    assert found.X_PC.GetDeterministicValue().translation()[2] == pytest.approx(0.2 + 1.1 * 0.023, abs=1e-5)


def test_one_free_model_is_asked_for(scenario):
    for models in (scenario.models[:2], [*scenario.models, replace(scenario.models[2], name="other")]):
        with refused("models"):
            with_object(replace(scenario, models=models), "box", DRAWN)


def test_a_grasp_that_begins_inside_a_finger_is_refused(monkeypatch):
    monkeypatch.setattr("soft_gripper.extras.recognition.random_grasps.draw", lambda *_: replace(DRAWN, x_mm=40.0))
    with refused("X_PC", "gripper::right_finger_link_6"):
        run_grasp("probing_grasp", 1, "test", 0, "box")


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [("sensor.errors=null",), ("sensor.errors={hysteresis: 0.05, quantization: 0.001}",)]
)
def test_probes_are_what_the_blocks_estimate_at_the_end_of_every_step(changes):
    """Means with ideal sensors, and with errors in which nothing is random."""
    scenario = load_scenario("probing_grasp", changes)
    station = make_station(with_object(scenario, "irregular", DRAWN))
    recording, rng = run_station(station), np.random.default_rng(0)
    found, time = probe(station, recording, 4, rng), recording["time"].values
    for level in range(3):
        (sample,) = np.flatnonzero(np.isclose(time, (level + 1) * scenario.step_duration))
        for i, finger in enumerate(NAMES):
            for values, signal in ((found.angles, "estimated_joint_angles"), (found.torques, "external_torque")):
                expected = recording[f"{finger}.{signal}"].values[sample - SAMPLES + 1 : sample + 1].mean(axis=0)
                for each in values:
                    np.testing.assert_allclose(each[level, i], expected, atol=1e-12)
    fewer = probe(station, recording, 2, rng)
    assert fewer.angles.shape == fewer.torques.shape == (len(found.angles), 3, 2, 12)
    assert np.abs(fewer.angles - found.angles).max() > 1e-3


@pytest.mark.slow
def test_every_grasp_has_sensors_of_its_own(monkeypatch):
    """One object, so that grasps differ by their sensors alone."""
    noisy = load_scenario("probing_grasp")
    monkeypatch.setattr("soft_gripper.extras.recognition.random_grasps.load_scenario", lambda file: noisy)
    monkeypatch.setattr("soft_gripper.extras.recognition.random_grasps.draw", lambda *_: DRAWN)
    one, again, other = (run_grasp("noisy", 1, "test", number, "box").probes[4].angles for number in (0, 0, 1))
    np.testing.assert_array_equal(again, one)
    assert 1e-4 < np.abs(other - one).max() < 0.1


@pytest.mark.slow
def test_the_block_in_a_station_recognizes_as_the_model_does_from_the_recording(scenario):
    """Components at random: two probabilities that have nothing to do with shapes, but with every feature."""
    pressures = np.array(scenario.pressure.steps["all"])
    components = np.random.default_rng(1).normal(size=(1, 4 * 3 * 12))
    means, variances = np.array([[-1.0], [1.0]]), np.array([[[2.0]], [[2.0]]])
    model = ObjectClassifier(("one", "other"), 2, 12, 4, pressures, np.zeros(144), components, means, variances, 50.0)
    builder = DiagramBuilder()
    station = add_station(builder, with_object(scenario, "cylinder", DRAWN))
    recognizer = builder.AddNamedSystem("recognizer", ObjectRecognizer(model, NAMES, scenario.sensor.period))
    for i in range(recognizer.num_input_ports()):
        port = recognizer.get_input_port(i)
        builder.Connect(station.signals[port.get_name()], port)
    signals = station.signals | {"recognized": recognizer.get_output_port()}
    logs = add_logs(builder, signals, scenario.sensor.period)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(scenario.duration + 0.02)
    recording = read_logs(logs, simulator.get_context(), {})
    assert list(recording["recognized"]["shape"].values) == ["one", "other", "unknown"]
    probabilities = recording["recognized"].values
    expected = probe(make_station(scenario), recording, 4, np.random.default_rng(0))
    begin = recording["time"].values < 2 * scenario.step_duration
    assert np.isnan(probabilities[begin]).all()
    (found,) = model.probabilities(expected.angles, expected.torques)
    np.testing.assert_allclose(probabilities[-1], found, atol=0.01)
