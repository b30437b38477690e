"""Logs: every sample once, with units and axes, of vectors and of other values."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.recording import Recording, read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.signals import XZ, describe

PHASES = ("go there", "close", "over")


def recorded(**signals):
    """A recording of constants, counted up, each with what `describe` takes; names with __ in the place of a dot."""
    builder, ports = DiagramBuilder(), {}
    for name, (unit, axes) in signals.items():
        size = int(np.prod([len(labels) for labels in axes.values()]))
        source = builder.AddSystem(ConstantVectorSource(np.arange(size, dtype=float)))
        ports[name.replace("__", ".")] = describe(source.get_output_port(), unit, **axes)
    logs = add_logs(builder, ports, 0.1)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.25)
    return read_logs(logs, simulator.get_context())


def test_units_of_each_entry():
    data = recorded(a__pose=(["m", "rad"], {"joint": range(2), "part": ("x", "heading")}))["a.pose"]
    assert data.attrs["units"] == "m, rad"
    assert data["part_units"].dims == ("part",)
    assert data["part_units"].values.tolist() == ["m", "rad"]


def test_other_axes_have_the_name_of_their_owner():
    """Of one owner they are shared."""
    recording = recorded(
        a__q=("rad", {"joint": range(3)}),
        a__points=("m", {"joint": range(3), "xz": XZ}),
        b__q=("rad", {"joint": range(5)}),
    )
    assert recording["a.q"].dims == ("time", "a.joint")
    assert recording["a.points"].dims == ("time", "a.joint", "xz")
    assert recording["b.q"].dims == ("time", "b.joint")
    assert recording["b.q"].sel({"b.joint": 4})[-1] == 4


def test_axes_that_differ_within_one_owner_have_the_name_of_the_signal():
    recording = recorded(arm__q=(["m", "rad"], {"joint": range(2)}), arm__v=(["m/s", "rad/s"], {"joint": range(2)}))
    for name, units in (("arm.q", ["m", "rad"]), ("arm.v", ["m/s", "rad/s"])):
        assert recording[name].dims == ("time", f"{name}.joint")
        assert recording[name][f"{name}.joint_units"].values.tolist() == units


@pytest.fixture
def phases():
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource([1.0]))
    logs = add_logs(builder, {"task.phase": describe(source.get_output_port(), meanings=PHASES)}, 0.1)
    return read_logs(logs, Simulator(builder.Build()).get_context())


def test_states_are_named_as_the_cf_conventions_have_it(phases, tmp_path):
    phases.save(tmp_path / "a.nc")
    for recording in (phases, Recording.load(tmp_path / "a.nc")):
        attributes = recording["task.phase"].attrs
        assert attributes["units"] == "1"
        assert np.asarray(attributes["flag_values"]).tolist() == [0, 1, 2]
        assert attributes["flag_meanings"] == "go_there close over"


def test_every_sample_is_there_once():
    """A ramp sampled at 0, 0.125 and 0.25 s, of which a log at a time shows the one before."""
    builder = DiagramBuilder()
    ramp = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, 1.0], [[0.0, 5.0]])))
    held = builder.AddSystem(ZeroOrderHold(0.125, 1))
    builder.Connect(ramp.get_output_port(), held.get_input_port())
    logs = add_logs(builder, {"ramp": held.get_output_port()}, 0.125)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.375)
    recording = read_logs(logs, simulator.get_context())
    np.testing.assert_allclose(recording.samples("ramp").ravel(), [0.0, 0.625, 1.25])
    np.testing.assert_array_equal(recording.samples("ramp")[recording.sample_numbers], recording.values("ramp"))


class Clock(ArrayBlock):
    """Puts the time out as a string."""

    def __init__(self):
        super().__init__()
        self.show("text", lambda context: f"{context.get_time():.1f}", {self.time_ticket()})


def test_values_are_kept_with_the_period_and_every_run_begins_anew():
    builder = DiagramBuilder()
    clock = builder.AddSystem(Clock())
    log = clock.log("text", 0.5)
    diagram = builder.Build()
    for end, expected in ((1.2, ["0.0", "0.5", "1.0"]), (0.7, ["0.0", "0.5"])):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(end)
        assert log.Eval(clock.GetMyContextFromRoot(simulator.get_context())) == expected
