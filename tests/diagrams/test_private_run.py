"""A run whose diagram nobody sees has only the blocks that something reads, and the numbers of all of them."""

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping
from finger_plants import free_bending
from logged_ports import logged_ports
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.live import LiveSignals
from soft_gripper.diagrams.private_run import keep_what_is_read
from soft_gripper.diagrams.simulation import make_simulator, run_station
from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_block import Hold

PERIOD = 0.1
SHORT = "control.hold=0.3", "control.set_points=[0.085, 0.095]"
CLOSED = {
    "ideal sensors": [],
    "realistic sensors": ["sensor.errors.preset=realistic", "sensor.errors.delay=1"],
    "errors of the pressure": ["sensor.pressure_errors={noise: 500.0, delay: 2, offset: 1000.0}"],
    "lost readings": ["sensor.errors.dropout=0.05", "sensor.sections=2"],
}


def assert_near(recording, other, share):
    """Every signal, relative to its size."""
    assert set(recording.data) == set(other.data)
    for name in recording.data:
        values, others = recording[name].values, other[name].values
        scale = np.abs(others[np.isfinite(others)]).max(initial=1e-300)
        np.testing.assert_allclose(values, others, rtol=0, atol=share * scale, err_msg=name)


def both(scenario):
    """The recordings of a private station and of one whose every port can be read."""
    return (run_station(make(scenario)) for make in (make_private_station, make_station))


@pytest.mark.slow
@pytest.mark.parametrize("overrides", CLOSED.values(), ids=CLOSED)
def test_a_closed_loop_is_that_of_the_blocks_themselves(overrides):
    recording, every = both(load_scenario("tip_distance_steps", [*SHORT, *overrides]))
    assert_near(recording, every, 1e-12)
    assert np.ptp(recording["left_finger.pressure_command"].values) > 1e3, "the loop does something"


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["gaussian", "contact", "recursive"])
def test_where_matrices_of_both_fingers_are_inverted_at_once_a_loop_differs_by_rounding(estimator):
    overrides = [*SHORT, f"estimator.type={estimator}", "sensor.errors.preset=realistic"]
    assert_near(*both(load_scenario("tip_distance_steps", overrides)), 1e-8)


@pytest.mark.slow
def test_fingers_that_creep(tmp_path):
    """What drives them follows from their estimates, and these from what drives them."""
    files = [f"models.{i}.file={write_creeping(FINGER, tmp_path, 0.2, 0.5)}" for i in range(2)]
    overrides = [*files, "pressure.settle=0.2", "pressure.hold_samples=5"]
    assert_near(*both(load_scenario("free_bending", overrides)), 1e-12)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("free_bending", []),
        ("free_bending", CLOSED["realistic sensors"]),
        ("tip_distance_steps", []),
        ("tip_distance_steps", CLOSED["realistic sensors"]),
    ],
)
def test_a_private_diagram_exports_what_it_computes(name, overrides):
    scenario = load_scenario(name, overrides)
    station = make_private_station(scenario)
    simulator = make_simulator(station)
    simulator.AdvanceTo(0.1)
    read = logged_ports(scenario, 0.1)
    diagram = station.diagram
    exported = [diagram.get_output_port(i) for i in range(diagram.num_output_ports())]
    assert {port.get_name() for port in exported} == set(station.parts.signals)
    assert {"plant.state", "left_finger.pressure_command"} <= set(station.parts.signals) < set(read)
    for port in exported:
        assert port.Eval(simulator.get_context()).shape == read[port.get_name()][-1].shape
    names = {system.get_name() for system in diagram.GetSystems()}
    assert not names & {"left_finger.sensors", "left_finger.estimation", "left_finger.scoring", "true_poses"}
    assert station.removed.keys() >= {"left_finger.sensors", "left_finger.estimation"}


def test_nothing_read_is_nothing_added():
    def live(name):
        return [s for s in make_private_station(load_scenario(name)).diagram.GetSystems() if isinstance(s, LiveSignals)]

    assert not live("free_bending")
    assert len(live("tip_distance_steps")) == 1


def test_a_private_run_begins_at_any_time():
    station = make_private_station(free_bending([50e3, 80e3], 0.1, "sensor.errors.preset=realistic"))
    runs = []
    for begin in (0.0, 10.0):
        simulator = make_simulator(station)
        simulator.get_mutable_context().SetTime(begin)
        simulator.AdvanceTo(begin + 0.15)
        runs.append(station.recording(simulator.get_context()))
    assert_near(*runs, 1e-12)


class Waves:
    """Sources, and blocks that hold what they put out."""

    def __init__(self, *delays):
        self.builder, self.holds, self.sources = DiagramBuilder(), [], []
        for delay in delays:
            bend = PiecewisePolynomial.FirstOrderHold([0, 10], [[len(self.holds), 10 + delay]])
            source = self.builder.AddNamedSystem(f"source{len(self.sources)}", TrajectorySource(bend))
            hold = self.builder.AddNamedSystem(f"hold{len(self.holds)}", Hold(PERIOD, 1, delay))
            self.builder.Connect(source.get_output_port(), hold.get_input_port())
            self.sources.append(source)
            self.holds.append(hold)

    def logs(self, is_private):
        """What is logged of all blocks in a run, and the names of the blocks."""
        logs = [LogVectorOutput(hold.get_output_port(), self.builder, PERIOD) for hold in self.holds]
        if is_private:
            keep_what_is_read(self.builder, PERIOD, {})
        diagram = self.builder.Build()
        simulator = Simulator(diagram)
        simulator.AdvanceTo(1.0)
        names = {system.get_name() for system in diagram.GetSystems()}
        return np.array([log.FindLog(simulator.get_context()).data()[0] for log in logs]), names


@pytest.mark.parametrize("delays", [(0,), (2, 2), (0, 2, 0), (1, 1, 3, 1)])
def test_blocks_that_are_alike_keep_their_own_samples(delays):
    found, names = Waves(*delays).logs(is_private=True)
    assert "live" in names
    assert not any(name.startswith("hold") for name in names)
    np.testing.assert_array_equal(found, Waves(*delays).logs(is_private=False)[0])
    assert len(np.unique(found[:, -1])) == len(delays)


def test_blocks_that_are_alike_may_follow_each_other():
    def chained(is_private):
        waves = Waves(1)
        again = waves.builder.AddNamedSystem("again", Hold(PERIOD, 1, 1))
        waves.builder.Connect(waves.holds[0].get_output_port(), again.get_input_port())
        waves.holds.append(again)
        return waves.logs(is_private)[0]

    np.testing.assert_array_equal(chained(True), chained(False))


class Double(ArrayBlock):
    def __init__(self):
        super().__init__()
        self.take("x", 1)
        self.put_out("y", lambda x: 2 * x, "x")


def test_other_periods_and_what_is_not_sampled_run_by_themselves():
    waves = Waves(0)
    double, slow = waves.builder.AddNamedSystem("double", Double()), Hold(2 * PERIOD, 1)
    waves.builder.AddNamedSystem("slow", slow)
    for block in (double, slow):
        waves.builder.Connect(waves.sources[0].get_output_port(), block.get_input_port())
    waves.holds += [double, slow]
    found, names = waves.logs(is_private=True)
    assert names >= {"double", "slow", "live"}
    assert "hold0" not in names
    time = PERIOD * np.arange(11)
    np.testing.assert_allclose(found[1], 2 * time)
    np.testing.assert_allclose(found[2][1:], np.floor((time[1:] - 1e-9) / (2 * PERIOD)) * 2 * PERIOD)


class Reader(LeafSystem):
    def __init__(self):
        super().__init__()
        self._x = self.DeclareVectorInputPort("x", 1)
        self.DeclareVectorOutputPort("y", 1, lambda context, y: y.SetFromVector(3 * self._x.Eval(context)))


def test_a_block_of_another_kind_gets_what_it_reads():
    waves = Waves(0, 0)
    reader = waves.builder.AddNamedSystem("reader", Reader())
    waves.builder.Connect(waves.holds[1].get_output_port(), reader.get_input_port())
    waves.holds = [*waves.holds[:1], reader]
    found, _ = waves.logs(is_private=True)
    assert found[1, -1] == pytest.approx(3 * (1 + 9 * 0.9 / 10))


def test_what_a_block_of_another_kind_reads_inside_of_its_part_stays_with_it():
    """A part of a diagram stays whole, and with it what feeds it."""

    class Part(Diagram):
        def __init__(self):
            super().__init__()
            builder = DiagramBuilder()
            hold, reader = builder.AddNamedSystem("hold", Hold(PERIOD, 1)), builder.AddNamedSystem("reader", Reader())
            builder.Connect(hold.get_output_port(), reader.get_input_port())
            builder.ExportInput(hold.get_input_port(), "u")
            builder.ExportOutput(reader.get_output_port(), "y")
            builder.BuildInto(self)

    def read(is_private):
        waves = Waves(1, 0)
        part = waves.builder.AddNamedSystem("part", Part())
        waves.builder.Connect(waves.holds[0].get_output_port(), part.get_input_port())
        waves.holds = [part]
        return waves.logs(is_private)

    (found, names), (expected, _) = read(True), read(False)
    np.testing.assert_array_equal(found, expected)
    assert "part" in names
    assert "hold1" not in names, "nothing reads it"
