"""Functions of a block over many environments: what they say of an input that is not finite."""

import numpy as np
import pytest
from pydrake.systems.primitives import DiscreteTimeIntegrator

pytest.importorskip("mujoco")

from soft_gripper.array_block import ArrayBlock
from soft_gripper.control.pid_controller import PidController, PidGains
from soft_gripper.errors import InputError
from soft_gripper.extras.mujoco_engine.blocks import Contexts, Functions
from soft_gripper.steps import row_by_row


class Solving(ArrayBlock):
    """A step and an output that fail on what is not finite."""

    def __init__(self):
        super().__init__()
        self.take("x", 1)
        self.derive("checked", np.asarray_chkfinite, "x")
        self.put_out("of_step", lambda x: x, "checked")
        self.put_out("of_input", np.asarray_chkfinite, "x")


@pytest.mark.parametrize("number", [0, 1])
def test_a_failure_names_the_block_and_the_input_of_any_environment(number):
    values = np.ones((3, 1))
    block = Solving()
    functions = Functions(block, block.steps.stacked(3), 3)
    assert functions.output(number, lambda _: values, 0.0).shape == (3, 1)
    functions.forget()
    values[1] = np.nan
    with pytest.raises(InputError, match="x = nan: must be finite"):
        functions.output(number, lambda _: values, 0.0)


class Counting(ArrayBlock):
    """Adds up an input for one environment at a time."""

    takes_axes = False

    def __init__(self):
        super().__init__(0.1)
        self.take("u", 1)
        self.remember("sum", lambda total, u: total + 0.1 * u, "u", begin=np.zeros(1), keep=lambda total: total)
        self.put_out("y", lambda total: total, "sum")


def functions_of(block, count):
    return Functions(block, row_by_row([block.steps] * count), count)


@pytest.mark.parametrize(
    "make", [lambda: Contexts(DiscreteTimeIntegrator(1, 0.1), 2), lambda: functions_of(Counting(), 2)]
)
def test_a_state_begins_anew_in_one_of_two_environments(make):
    both, values, found = make(), np.array([[1.0], [2.0]]), []
    for rows in (np.array([0, 1]), np.array([0])):
        both.clear(rows)
        for _ in range(4):
            both.advance(lambda _: values, 0.0, np.array([0, 1]))
            both.commit()
        found.append(both.output(0, lambda _: values, 0.0)[:, 0])
    assert found[1] == pytest.approx(found[0] + np.array([0.0, 4 * 2 * 0.1]))


@pytest.mark.parametrize("applied", [None, np.array([[0.5], [-3.0], [0.0]])])
def test_controllers_of_many_environments_do_what_one_does_alone(applied):
    """Also while nothing feeds back what is applied."""
    pid, found = PidController(PidGains(2.0, 5.0, 0.3), 0.1, -1.0, 1.0), []
    inputs = np.random.default_rng(1).uniform(-1, 1, (6, 2, 3, 1))
    for rows in (slice(None), *([row] for row in range(3))):
        many, outputs = functions_of(pid, len(np.arange(3)[rows])), []
        for given in inputs:
            ports = [*given[:, rows], None if applied is None else applied[rows]]
            outputs.append(many.output(0, ports.__getitem__, 0.0)[:, 0])
            many.advance(ports.__getitem__, 0.0, np.arange(3)[rows])
            many.commit()
        found.append(np.array(outputs))
    np.testing.assert_array_equal(found[0], np.hstack(found[1:]))
    assert len(np.unique(found[0])) > 6
