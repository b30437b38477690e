"""ArrayBlock: functions of arrays as ports for one sample, and over all samples of a recording at once."""

import numpy as np
import pytest

from soft_gripper.array_block import ArrayBlock
from soft_gripper.signals import signal_of

PERIOD = 0.5


class Summing(ArrayBlock):
    """Squares, their sum beside a second input, and what it remembers of the sample before."""

    def __init__(self):
        super().__init__()
        self.calls = 0
        self.take("x", 3)
        self._y = self.take("y", 1)
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)
        self.derive("squares", self._square, "x")
        self.remember("pair", self._pair, "y", over_time=_pairs, period=PERIOD)
        self.remember("state", lambda context: context.get_discrete_state_vector().value())
        self.put_out("squares", lambda squares: squares, "squares", unit="m^2", axis=range(3))
        self.put_out("sum", lambda squares, y: squares.sum(axis=-1) + y[..., 0], "squares", "y", unit="m^2")
        self.put_out("change", lambda pair: pair[..., 1] - pair[..., 0], "pair")
        self.put_out("state", lambda state: state, "state")

    def _square(self, x):
        self.calls += 1
        return x**2

    def _pair(self, context):
        return np.array([context.get_discrete_state_vector().value()[0], self._y.Eval(context)[0]])

    def _update(self, context, values):
        values.set_value(self._y.Eval(context))


def _pairs(time, y):
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


def test_what_a_run_alone_knows_does_not_follow(block):
    assert not block.follows("state", PERIOD)
    assert not block.follows("no_port_of_it", PERIOD)


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
