"""What a loop reads is computed by one block, with the numbers of the blocks that it stands for."""

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Gain, LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.array_block import ArrayBlock, RestingError
from soft_gripper.diagrams.live import LiveSignals, add_live, wake_all
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
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


def difference(recording, other):
    """The largest of any signal, relative to its size."""
    assert set(recording.data) == set(other.data)
    return max(_difference(recording[name].values, other[name].values) for name in recording.data)


def _difference(values, others):
    np.testing.assert_array_equal(np.isnan(values), np.isnan(others))
    known = np.isfinite(values)
    return np.abs(values - others)[known].max(initial=0.0) / np.abs(others[known]).max(initial=1e-300)


@pytest.mark.slow
@pytest.mark.parametrize("overrides", CLOSED.values(), ids=CLOSED)
def test_a_closed_loop_is_that_of_the_blocks_themselves(overrides):
    overrides = [*SHORT, *overrides]
    live, alone = (load_scenario("tip_distance_steps", [*overrides, f"record.live={each}"]) for each in (False, True))
    recording = simulate(live)
    assert difference(recording, simulate(alone)) <= 1e-12
    assert np.ptp(recording["left_finger.pressure_command"].values) > 1e3, "the loop does something"


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["gaussian", "contact", "recursive"])
def test_where_matrices_of_both_fingers_are_inverted_at_once_a_loop_differs_by_rounding(estimator):
    overrides = [*SHORT, f"estimator.type={estimator}", "sensor.errors.preset=realistic"]
    live, alone = (load_scenario("tip_distance_steps", [*overrides, f"record.live={each}"]) for each in (False, True))
    assert difference(simulate(live), simulate(alone)) <= 1e-8


@pytest.mark.slow
def test_fingers_that_creep(tmp_path):
    """What drives them follows from their estimates, and these from what drives them."""
    files = [f"models.{i}.file={write_creeping(FINGER, tmp_path, 0.2, 0.5)}" for i in range(2)]
    overrides = [*files, "pressure.settle=0.2", "pressure.hold_samples=5"]
    recordings = [
        simulate(load_scenario("free_bending", [*overrides, f"record.live={each}"])) for each in (False, True)
    ]
    assert difference(*recordings) <= 1e-12


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

    def logs(self, runs_live):
        """What is logged of all blocks in a run."""
        logs = [LogVectorOutput(hold.get_output_port(), self.builder, PERIOD) for hold in self.holds]
        if runs_live:
            add_live(self.builder, PERIOD)
        simulator = Simulator(self.builder.Build())
        simulator.AdvanceTo(1.0)
        return np.array([log.FindLog(simulator.get_context()).data()[0] for log in logs])


@pytest.mark.parametrize("delays", [(0,), (2, 2), (0, 2, 0), (1, 1, 3, 1)])
def test_blocks_that_are_alike_keep_their_own_samples(delays):
    found = Waves(*delays).logs(runs_live=True)
    np.testing.assert_array_equal(found, Waves(*delays).logs(runs_live=False))
    assert len(np.unique(found[:, -1])) == len(delays)


def test_blocks_that_are_alike_may_follow_each_other():
    def chained(runs_live):
        waves = Waves(1)
        again = waves.builder.AddNamedSystem("again", Hold(PERIOD, 1, 1))
        waves.builder.Connect(waves.holds[0].get_output_port(), again.get_input_port())
        waves.holds.append(again)
        return waves.logs(runs_live)

    np.testing.assert_array_equal(chained(True), chained(False))


def test_other_periods_and_what_is_not_sampled_run_by_themselves():
    class Double(ArrayBlock):
        def __init__(self):
            super().__init__()
            self.take("x", 1)
            self.put_out("y", lambda x: 2 * x, "x")

    waves = Waves(0)
    double, slow = waves.builder.AddNamedSystem("double", Double()), Hold(2 * PERIOD, 1)
    waves.builder.AddNamedSystem("slow", slow)
    for block in (double, slow):
        waves.builder.Connect(waves.sources[0].get_output_port(), block.get_input_port())
    waves.holds += [double, slow]
    waves.logs(runs_live=True)
    live = waves.builder  # already built
    assert live.already_built()
    context = slow.CreateDefaultContext()
    np.testing.assert_array_equal(slow.get_output_port().Eval(context), [0])  # does not rest
    with pytest.raises(RestingError):
        waves.holds[0].get_output_port().Eval(waves.holds[0].CreateDefaultContext())


def test_nothing_read_is_nothing_added():
    station = make_station(load_scenario("free_bending"))
    assert not station.diagram.HasSubsystemNamed("live")
    assert any(
        isinstance(each, LiveSignals) for each in make_station(load_scenario("tip_distance_steps")).diagram.GetSystems()
    )


def test_all_may_be_woken():
    waves = Waves(0)
    waves.builder.Connect(waves.holds[0].get_output_port(), waves.builder.AddSystem(Gain(1.0, 1)).get_input_port())
    wake_all(waves.builder)
    diagram = waves.builder.Build()
    assert not diagram.HasSubsystemNamed("live")


def test_a_port_is_read_during_a_run_only_where_every_block_runs():
    for is_live in (False, True):
        station = make_station(load_scenario("free_bending", [f"record.live={is_live}"]))
        simulator = Simulator(station.diagram)
        simulator.AdvanceTo(0.1)
        port = station.diagram.GetOutputPort("left_finger.tip_pose")
        if is_live:
            assert np.isfinite(port.Eval(simulator.get_context())).all()
        else:
            with pytest.raises(RestingError, match="rests"):
                port.Eval(simulator.get_context())


def test_a_station_with_open_inputs_can_be_read_from_outside():
    station = make_station(load_scenario("free_bending", ["external=[pressure]"]))
    context = station.diagram.CreateDefaultContext()
    assert np.isfinite(station.diagram.GetOutputPort("left_finger.tip_pose").Eval(context)).all()


def test_a_block_of_the_users_gets_what_it_reads():
    """A block of another kind, in a part of the diagram that also has blocks of functions."""

    class Reader(LeafSystem):
        def __init__(self):
            super().__init__()
            self._x = self.DeclareVectorInputPort("x", 1)
            self.DeclareVectorOutputPort("y", 1, lambda context, y: y.SetFromVector(3 * self._x.Eval(context)))

    waves = Waves(0, 0)
    reader = waves.builder.AddNamedSystem("reader", Reader())
    waves.builder.Connect(waves.holds[1].get_output_port(), reader.get_input_port())
    waves.holds = [*waves.holds[:1], reader]
    found = waves.logs(runs_live=True)
    assert found[1, -1] == pytest.approx(3 * (1 + 9 * 0.9 / 10))


def test_a_diagram_may_be_logged_in_two_parts():
    waves = Waves(0, 1)
    first, second = (LogVectorOutput(hold.get_output_port(), waves.builder, PERIOD) for hold in waves.holds)
    add_live(waves.builder, PERIOD)
    gain = waves.builder.AddNamedSystem("gain", Gain(2.0, 1))
    waves.builder.Connect(waves.holds[0].get_output_port(), gain.get_input_port())
    third = LogVectorOutput(gain.get_output_port(), waves.builder, PERIOD)
    add_live(waves.builder, PERIOD)
    simulator = Simulator(waves.builder.Build())
    simulator.AdvanceTo(1.0)
    found = [log.FindLog(simulator.get_context()).data()[0] for log in (first, second, third)]
    np.testing.assert_array_equal(found[2], 2 * found[0])
    assert found[0][-1] != found[1][-1]
