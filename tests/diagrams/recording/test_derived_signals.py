"""Signals that follow from others: traced to what is logged, computed when they are read."""

from unittest.mock import patch

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping
from logged_ports import LoggedStation, assert_same
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Gain, Sine

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.diagrams.signal_sources import DerivedOutput, LoggedPort, SignalSources
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.truth.poses import Difference

SHORT = "pressure.settle=0.2", "pressure.hold_samples=5"
ALONGSIDE = "estimator.alongside=[spline, gaussian, contact, recursive]"
DROPOUT = "sensor.errors.preset=realistic", "sensor.errors.dropout=0.05"
CONTACT = "estimator.contact_threshold=2.5e-3"
SCENARIOS = {
    "all_estimators": ("box_grasp", [*SHORT, ALONGSIDE, "sensor.sections=2"], 2.0),
    "sensors_that_fail": ("obstructed_inside", [*SHORT, *DROPOUT, ALONGSIDE, CONTACT], 1.0),
    "one_of_everything_continuous": ("irregular_grasp", [*SHORT, "plant_config.time_step=0.0"], 0.5),
    "moved_by_an_arm": ("pick_and_place_box", [], 0.6),
}


def run(name, overrides, duration):
    """Every signal of a run, {signal: (T, size)}: as recorded, and by a log for each port; and the logs."""
    station = LoggedStation(load_scenario(name, overrides))
    simulator = station.simulator()
    simulator.AdvanceTo(duration)
    return station.recorded(simulator), station.logged(simulator), station.station.logs


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_recording_is_what_the_blocks_compute(name):
    found, expected, logs = run(*SCENARIOS[name])
    assert_same(found, expected)
    assert len(logs.port_numbers) < 0.75 * len(found)


@pytest.mark.slow
def test_a_finger_that_creeps(tmp_path):
    """What it remembers follows from a run alone."""
    files = [f"models.{i}.file={write_creeping(FINGER, tmp_path, 0.2, 0.5)}" for i in range(2)]
    found, expected, logs = run("free_bending", [*SHORT, *files], 1.0)
    assert_same(found, expected)
    assert "left_finger.driving_torque" in logged_names(logs)


def logged_names(logs):
    return {logs.get_input_port(i).get_name() for i in range(logs.num_input_ports())}


class Chain:
    """sine -> gain -> difference <- constant, of which parts may be left out."""

    def __init__(self, connects_truth=True):
        self.builder = DiagramBuilder()
        sine, self.gain = self.builder.AddSystem(Sine(1.0, 1.0, 0.0, 1)), self.builder.AddSystem(Gain(2.0, 1))
        self.difference = self.builder.AddSystem(Difference(1, "m"))
        self.builder.Connect(sine.get_output_port(0), self.gain.get_input_port())
        self.builder.Connect(self.gain.get_output_port(), self.difference.GetInputPort("estimate"))
        if connects_truth:
            truth = self.builder.AddSystem(ConstantVectorSource([3.0]))
            self.builder.Connect(truth.get_output_port(), self.difference.GetInputPort("truth"))


def test_what_follows_is_traced_to_what_does_not():
    chain = Chain()
    sources = SignalSources(chain.builder, 0.1)
    found = sources.find(chain.difference.get_output_port())
    assert isinstance(found, DerivedOutput)
    gain = sources.find(chain.gain.get_output_port())
    assert found.derived.leaves["estimate"] == gain
    assert isinstance(gain, LoggedPort)
    assert sources.ports[gain.number] == chain.gain.get_output_port()


def test_of_what_leads_round_in_a_circle_something_is_logged():
    builder = DiagramBuilder()
    first, second = (builder.AddSystem(Difference(1, "m")) for _ in range(2))
    for one, other in ((first, second), (second, first)):
        for port in map(other.get_input_port, range(2)):
            builder.Connect(one.get_output_port(), port)
    logs = add_logs(builder, {"first": first.get_output_port(), "second": second.get_output_port()}, 0.1)
    assert len(logs.port_numbers) == 1


class TwoWays(ArrayBlock):
    """Doubles either of two inputs."""

    def __init__(self):
        super().__init__()
        for name in "ab":
            self.take(name, 1)
            self.put_out(f"twice_{name}", lambda x: 2 * x, name)


def test_a_block_may_follow_from_what_follows_from_another_output_of_it():
    builder = DiagramBuilder()
    source, block = builder.AddNamedSystem("source", ConstantVectorSource([3.0])), builder.AddSystem(TwoWays())
    between = builder.AddSystem(TwoWays())
    builder.Connect(source.get_output_port(), block.GetInputPort("a"))
    builder.Connect(block.GetOutputPort("twice_a"), between.GetInputPort("a"))
    builder.Connect(between.GetOutputPort("twice_a"), block.GetInputPort("b"))
    names = ("twice_b", "twice_a")
    logs = add_logs(builder, {name: block.GetOutputPort(name) for name in names}, 0.1)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.1)
    assert logged_names(logs) == {"source.y0"}
    found = logs.samples(simulator.get_context())
    assert [found[name].tolist() for name in names] == [[[24.0], [24.0]], [[6.0], [6.0]]]


BRIEF = "estimator.type=contact", "sensor.sections=2", "pressure.steps.all=[60e3]", "pressure.settle=0.2"
POSTERIOR = "left_finger.contact_force_bounds", "left_finger.contact_probability"


@pytest.fixture(scope="module")
def recording():
    return simulate(load_scenario("free_bending", [*BRIEF, "pressure.hold_samples=5"]))


def test_what_is_not_read_is_not_computed():
    with patch.object(ContactShape, "posterior", autospec=True, side_effect=ContactShape.posterior) as posterior:
        found = simulate(load_scenario("free_bending", [*BRIEF, "pressure.hold_samples=5"]))
        assert np.isfinite(found["left_finger.tip_pose"].values).all()
        assert posterior.call_count == 0
        twice = [[found[name].values for name in POSTERIOR] for _ in range(2)]
        assert posterior.call_count == 1, "both follow from one posterior"
        np.testing.assert_array_equal(twice[0][1], twice[1][1])


@pytest.mark.parametrize("estimator", ["arcs", "contact"])
def test_a_run_computes_no_estimate(estimator):
    """Of a signal that nothing in the diagram takes."""
    scenario = load_scenario("free_bending", [*BRIEF, "pressure.hold_samples=5", f"estimator.type={estimator}"])
    with patch.object(ArrayBlock, "output_over_time", autospec=True, side_effect=ArrayBlock.output_over_time) as output:
        found = simulate(scenario)
        assert output.call_count == 0
        assert np.isfinite(found["left_finger.tip_pose"].values).all()
        assert output.call_count > 0


@pytest.mark.parametrize("signal", ["estimated_joint_angles", "tip_pose", "external_torque"])
def test_an_estimate_without_readings_is_noted_when_it_is_read(signal, caplog):
    """Whichever of its signals that is, and once."""
    dead = "sensor.errors={dead: [{path: inner, section: 0}]}"
    found = simulate(load_scenario("free_bending", [*BRIEF, "pressure.hold_samples=5", "estimator.type=arcs", dead]))
    assert np.isnan(found["left_finger.strain"].values).any()
    assert caplog.text == ""
    assert np.isnan(found[f"left_finger.{signal}"].values).all()
    said = "left_finger.estimated_joint_angles: NaN in 26 of 26 samples, first at t = 0 s"
    assert [record.getMessage() for record in caplog.records] == [said]
    found.data.load()
    assert [record.getMessage() for record in caplog.records if "left_finger" in record.getMessage()] == [said]
