"""ArrayBlock: functions of arrays as ports for one sample, and over all samples of a recording at once."""

import weakref

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.signal_sources import DerivedBlock, DerivedOutput, LoggedPort, Samples
from soft_gripper.errors import InputError
from soft_gripper.signals import signal_of
from soft_gripper.steps import TIME

PERIOD = 0.5


class Summing(ArrayBlock):
    """Squares, their sum beside a second input, and what it remembers of the sample before."""

    def __init__(self):
        super().__init__(PERIOD)
        self.calls = 0
        self.take("x", 3)
        self.take("y", 1)
        self.derive("squares", self._square, "x")
        pair = {"begin": np.zeros(1), "keep": lambda pair: pair[..., 1:]}
        self.remember("pair", lambda before, y: np.concatenate([before, y], axis=-1), "y", over_time=_pairs, **pair)
        self.remember("sum of y", lambda before, y: before + y, "y", begin=np.zeros(1), keep=lambda total: total)
        self.sample("now", TIME)
        self.sample("sampled", "y", 7.0, at_initialization=False)
        self.sample("drawn", "y", at_first=False)
        self.constant("two", np.array([2.0]))
        self.put_out("squares", lambda squares: squares, "squares", unit="m^2", axis=range(3))
        self.put_out("sum", lambda squares, y: squares.sum(axis=-1) + y[..., 0], "squares", "y", unit="m^2")
        self.put_out("change", lambda pair: pair[..., 1] - pair[..., 0], "pair")
        self.put_out("total", lambda total: total, "sum of y")
        for name in ("now", "sampled", "drawn", "two"):
            self.put_out(name, lambda value: value, name)

    def _square(self, x):
        self.calls += 1
        return x**2


def _pairs(y):
    return np.stack([np.append(0.0, y[:-1, 0]), y[:, 0]], axis=-1)


@pytest.fixture
def block():
    return Summing()


@pytest.fixture
def context(block):
    context = block.CreateDefaultContext()
    block.GetInputPort("x").FixValue(context, [1.0, 2.0, 3.0])
    block.GetInputPort("y").FixValue(context, [10.0])
    return context


def test_ports_are_the_functions(block, context):
    np.testing.assert_array_equal(block.GetOutputPort("squares").Eval(context), [1, 4, 9])
    np.testing.assert_array_equal(block.GetOutputPort("sum").Eval(context), [24])
    assert signal_of(block.GetOutputPort("squares")).axes == {"axis": range(3)}


def test_a_step_is_computed_once_for_all_ports_and_only_when_its_sources_change(block, context):
    for _ in range(2):
        for name in ("squares", "sum"):
            block.GetOutputPort(name).Eval(context)
    block.GetInputPort("y").FixValue(context, [20.0])
    np.testing.assert_array_equal(block.GetOutputPort("sum").Eval(context), [34])
    assert block.calls == 1


def test_all_samples_at_once_are_the_samples(block, context):
    x, y = np.arange(12.0).reshape(4, 3), np.arange(4.0)[:, None]
    found = block.over_time(np.arange(4) * PERIOD, {"x": x, "y": y}, ["squares", "sum"])
    for row in range(4):
        block.GetInputPort("x").FixValue(context, x[row])
        block.GetInputPort("y").FixValue(context, y[row])
        for name, values in found.items():
            np.testing.assert_array_equal(values[row], block.GetOutputPort(name).Eval(context))


def test_what_is_remembered_follows_if_the_samples_are_its_own(block):
    assert block.follows("change", PERIOD)
    assert not block.follows("change", PERIOD / 2)
    assert block.follows("sum", PERIOD / 2)
    found = block.over_time(np.arange(3) * PERIOD, {"y": np.array([[1.0], [4.0], [9.0]])}, ["change"])
    np.testing.assert_array_equal(found["change"], [[1], [3], [5]])


NAMES = ("change", "total", "now", "sampled", "drawn")


def diagram_of(block):
    """A diagram in which y is 1 + 2 t, with a log of every output that is of one number."""
    builder = DiagramBuilder()
    builder.AddSystem(block)
    x = builder.AddSystem(ConstantVectorSource(np.zeros(3)))
    y = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold([0, 20], [[1, 41]])))
    for source, name in ((x, "x"), (y, "y")):
        builder.Connect(source.get_output_port(), block.GetInputPort(name))
    logs = {name: LogVectorOutput(block.GetOutputPort(name), builder, PERIOD) for name in NAMES}
    return builder.Build(), logs


def logged(logs, context):
    return {name: log.FindLog(context).data()[0] for name, log in logs.items()}


@pytest.fixture
def run(block):
    diagram, logs = diagram_of(block)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(3 * PERIOD)
    return logged(logs, simulator.get_context())


def test_a_run(run, block):
    """The samples before; at the first nothing is remembered yet, and what is drawn is not drawn again."""
    np.testing.assert_array_equal(run["now"], [0, 0, PERIOD, 2 * PERIOD])
    np.testing.assert_array_equal(run["sampled"], [7, 1, 2, 3])
    np.testing.assert_array_equal(run["drawn"], [1, 1, 2, 3])
    np.testing.assert_array_equal(run["total"], [1, 2, 2 + 3, 2 + 3 + 4])
    time, y = np.arange(4) * PERIOD, np.arange(1.0, 5.0)[:, None]
    np.testing.assert_array_equal(run["sampled"], block.over_time(time, {"y": y}, ["sampled"])["sampled"][:, 0])


def counter():
    class Counter(ArrayBlock):
        def __init__(self):
            super().__init__(0.01)
            self.constant("one", np.ones(1))
            self.remember("count", lambda n, one: n + one, "one", begin=np.zeros(1), keep=lambda n: n)
            self.put_out("count", lambda n: n, "count")

    return Counter()


@pytest.mark.parametrize("begin", [0.0, 0.5, 10.0, 1234.5])
def test_a_counter_counts_samples_whenever_it_begins(begin):
    block = counter()
    simulator = Simulator(block)
    context = simulator.get_mutable_context()
    context.SetTime(begin)
    simulator.AdvanceTo(begin + 0.1)
    assert block.get_output_port().Eval(context) == 10


def test_another_simulator_goes_on_where_one_has_ended():
    block = counter()
    simulator = Simulator(block)
    simulator.AdvanceTo(0.05)
    other = Simulator(block, simulator.get_context().Clone())
    other.Initialize()
    for each in (simulator, other):
        each.AdvanceTo(0.1)
        assert block.get_output_port().Eval(each.get_context()) == 10


def test_memory_takes_a_period():
    class Forgetful(ArrayBlock):
        def __init__(self):
            super().__init__()
            self.sample("now", TIME)

    with pytest.raises(ValueError, match="period"):
        Forgetful()


def test_what_an_output_follows_from(block):
    assert block.leaves("sum") == ["x", "y"]
    assert block.leaves("change") == ["y"]


class Shown(ArrayBlock):
    """Puts out words, and their number."""

    def __init__(self):
        super().__init__()
        text = self.take("count", 1)
        self.show("words", lambda context: ["word"] * int(text.Eval(context)[0]), {text.ticket()})
        self.derive("number", len, "words", over_time=lambda words: np.array([len(each) for each in words]))
        self.put_out("number", lambda number: float(number) if np.ndim(number) == 0 else number, "number")


def test_what_is_no_array_is_shown_and_read_as_a_list_of_samples():
    block = Shown()
    context = block.CreateDefaultContext()
    block.GetInputPort("count").FixValue(context, [2.0])
    assert block.GetOutputPort("words").Eval(context) == ["word", "word"]
    assert block.GetOutputPort("number").Eval(context) == 2
    assert block.leaves("number") == ["words"]
    found = block.over_time(np.zeros(2), {"words": [["a"], ["a", "b", "c"]]}, ["number"])
    np.testing.assert_array_equal(found["number"], [[1], [3]])


class Halves(ArrayBlock):
    """Two outputs of a step that follows from a larger one."""

    def __init__(self):
        super().__init__()
        self.take("x", 1)
        self.derive("table", lambda x: np.tile(x, 1000), "x")
        self.derive("row", self._row, "table")
        for i in range(2):
            self.put_out(f"half{i}", lambda row, i=i: row[..., i : i + 1].copy(), "row")
        self.rows: list[np.ndarray] = []

    def _row(self, table):
        self.rows.append(table[..., :2].copy())
        return self.rows[-1]


def test_a_step_is_kept_for_further_readers_alone():
    known = {"time": np.arange(3.0), "x": np.ones((3, 1))}
    Halves().output_over_time("half0", known)
    assert set(known) == {"time", "x", "row"}


def test_steps_are_forgotten_once_all_signals_are_read():
    """Only the outputs are kept, each computed once for all who read it."""
    block = Halves()
    derived = DerivedBlock(block, {"x": LoggedPort(0)}, ["half0", "half1"])
    sources = {f"signal{i}": DerivedOutput(derived, f"half{i}") for i in range(2)}
    samples = Samples(sources, np.arange(3.0), {0: np.ones((3, 1))})
    assert samples["signal0"] is samples["signal0"]
    step = weakref.ref(block.rows[-1])
    block.rows.clear()
    assert step() is not None
    assert samples["signal1"].shape == (3, 1)
    assert step() is None


class Solving(ArrayBlock):
    """Solves for its inputs, as linear algebra that checks them does, in a step that is kept and in an output."""

    def __init__(self):
        super().__init__()
        self.take("x", 2)
        self.take("y", 1)
        self.derive("root", lambda x: np.linalg.cholesky(x[..., None] * np.eye(2))[..., 1, 1], "x")
        self.put_out("root", lambda root: root, "root")
        self.put_out("y root", lambda y: np.linalg.cholesky(y[..., None])[..., 0, 0], "y")


@pytest.mark.parametrize(("port", "output"), [("x", "root"), ("y", "y root")])
@pytest.mark.parametrize("hostile", [np.nan, np.inf, 1e308])
def test_a_function_that_fails_on_an_input_that_is_not_finite_names_block_and_input(port, output, hostile, monkeypatch):
    """For one sample, and for a recording."""
    solve = np.linalg.cholesky

    def checked(matrix):
        if not np.isfinite(matrix @ matrix).all():
            raise np.linalg.LinAlgError("the text of numpy")
        return solve(matrix)

    monkeypatch.setattr(np.linalg, "cholesky", checked)
    block = Solving()
    block.set_name("solving")
    inputs = {"x": np.tile([4.0, 9.0], (3, 1)), "y": np.full((3, 1), 16.0)}
    assert block.over_time(np.arange(3.0), inputs, [output])[output][0] > 1
    inputs[port][1, -1] = hostile
    context = block.CreateDefaultContext()
    for name, values in inputs.items():
        block.GetInputPort(name).FixValue(context, values[1])
    found = []
    with np.errstate(all="ignore"), pytest.raises(InputError) as caught:
        block.GetOutputPort(output).Eval(context)
    found.append(caught.value)
    with np.errstate(all="ignore"), pytest.raises(InputError) as caught:
        block.over_time(np.arange(3.0), inputs, [output])
    for error in (*found, caught.value):
        assert (error.where, error.field) == ("::solving", port)
        assert error.value == pytest.approx(hostile, nan_ok=True)


def test_a_function_that_fails_on_finite_inputs_says_why_itself():
    block = Solving()
    context = block.CreateDefaultContext()
    block.GetInputPort("x").FixValue(context, [4.0, -9.0])
    block.GetInputPort("y").FixValue(context, [1.0])
    with pytest.raises(np.linalg.LinAlgError):
        block.GetOutputPort("root").Eval(context)


def test_an_optional_input_is_none_while_it_is_open():
    class Scaling(ArrayBlock):
        def __init__(self):
            super().__init__()
            self.take("x", 1)
            self.take("factor", 1, optional=True)
            self.put_out("y", lambda x, factor: x if factor is None else factor * x, "x", "factor")

    block = Scaling()
    context = block.CreateDefaultContext()
    block.GetInputPort("x").FixValue(context, [3.0])
    assert block.get_output_port().Eval(context) == 3
    block.GetInputPort("factor").FixValue(context, [2.0])
    assert block.get_output_port().Eval(context) == 6


def test_a_step_that_is_not_there_is_named_with_the_one_meant():
    block = ArrayBlock(PERIOD)
    block.take("x", 1)
    block.derive("smooth", np.square, "x")
    for declare in (lambda: block.put_out("y", np.square, "smoth"), lambda: block.derive("z", np.square, "smoth")):
        with pytest.raises(InputError, match=r"ArrayBlock: step = 'smoth': did you mean 'smooth'\?"):
            declare()
