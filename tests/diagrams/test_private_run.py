"""A run whose diagram nobody sees has only the blocks that something reads, and the numbers of all of them."""

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping
from logged_ports import logged_ports
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput, MatrixGain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.diagrams.private_run import LOOP, remove_unread_blocks
from soft_gripper.diagrams.simulation import make_simulator, run_station
from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.diagrams.wiring.composed import BatchedBlock
from soft_gripper.diagrams.wiring.grip_control import GripControl
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


def test_what_only_logs_read_of_the_plant_is_computed_from_its_own_ports():
    """The gains that select joint angles and contact torques are left out, and their signals follow."""
    station = make_private_station(load_scenario("free_bending"))
    assert not any(isinstance(system, MatrixGain) for system in station.diagram.GetSystems())
    assert {"left_finger.sampled_joint_angles", "left_finger.true_external_torque"} <= set(station.logs.signals)


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
    assert not names & {"left_finger.scoring", "right_finger.scoring", "true_poses"}
    assert station.removed.keys() >= {"left_finger.scoring", "right_finger.scoring", "true_poses"}


def test_sensors_and_estimation_of_equal_fingers_are_computed_at_once_in_one_block_if_anything_reads_them():
    def parts(name, *overrides):
        """The composed parts whose steps the loop has."""
        diagram = make_private_station(load_scenario(name, overrides)).diagram
        steps = diagram.GetSubsystemByName(LOOP).steps if diagram.HasSubsystemNamed(LOOP) else ()
        assert not any(isinstance(system, BatchedBlock | GripControl) for system in diagram.GetSystems())
        return {
            step.partition("/")[0] for step in steps if step.partition("/")[0].endswith((".sensors", ".estimation"))
        }

    assert not parts("free_bending")
    both = {"left_finger+right_finger.sensors", "left_finger+right_finger.estimation"}
    assert parts("tip_distance_steps") == both
    broken = "sensor.faults=[{finger: left_finger, kind: dead}]"
    apart = {"left_finger.sensors", "right_finger.sensors", "left_finger+right_finger.estimation"}
    assert parts("tip_distance_steps", broken) == apart


def test_the_loop_has_no_step_and_no_output_that_nothing_reads():
    """Contact is detected after the run, as nothing in the loop reads it."""
    loop = make_private_station(load_scenario("tip_distance_steps", ["estimator.contact_threshold=2.5e-3"]))
    block = loop.diagram.GetSubsystemByName(LOOP)
    assert {*block.outputs} == {"grip_control.pressure"}
    assert not any("contact_detector" in step or "object_width" in step for step in block.steps)


class Reader(LeafSystem):
    def __init__(self):
        super().__init__()
        self._x = self.DeclareVectorInputPort("x", 1)
        self.DeclareVectorOutputPort("y", 1, lambda context, y: y.SetFromVector(3 * self._x.Eval(context)))


class Part(Diagram):
    """A block of another kind that reads one made of functions."""

    def __init__(self):
        super().__init__()
        builder = DiagramBuilder()
        hold, reader = builder.AddNamedSystem("hold", Hold(PERIOD, 1)), builder.AddNamedSystem("reader", Reader())
        builder.Connect(hold.get_output_port(), reader.get_input_port())
        builder.ExportInput(hold.get_input_port(), "u")
        builder.ExportOutput(reader.get_output_port(), "y")
        builder.BuildInto(self)


def test_what_nothing_reads_leaves_the_diagram_and_the_rest_is_as_before():
    def run(is_private):
        builder = DiagramBuilder()
        wave = TrajectorySource(PiecewisePolynomial.FirstOrderHold([0, 10], [[0, 10]]))
        source = builder.AddNamedSystem("source", wave)
        holds = [builder.AddNamedSystem(f"hold{i}", Hold(PERIOD, 1, i)) for i in range(3)]
        part = builder.AddNamedSystem("part", Part())
        for earlier, later in ((source, holds[0]), (holds[0], holds[1]), (holds[1], part), (source, holds[2])):
            builder.Connect(earlier.get_output_port(), later.get_input_port())
        log = LogVectorOutput(part.get_output_port(), builder, PERIOD)
        signals = {f"hold{i}": hold.get_output_port() for i, hold in enumerate(holds)}
        kept = remove_unread_blocks(builder, signals) if is_private else None
        diagram = builder.Build()
        simulator = Simulator(diagram)
        simulator.AdvanceTo(1.0)
        names = {system.get_name() for system in diagram.GetSystems() if system is not log}
        return kept, names, log.FindLog(simulator.get_context()).data()

    (kept, names, found), (_, every, expected) = run(True), run(False)
    np.testing.assert_array_equal(found, expected)
    assert every - names == {"hold2"} == kept.removed.keys(), "nothing reads it"
    assert kept.signals.keys() == {"hold0", "hold1"}
