"""Blocks are equal by what their functions hold."""

from dataclasses import dataclass
from functools import cached_property, partial
from random import Random

import numpy as np
import pytest

from soft_gripper.array_block import ArrayBlock
from soft_gripper.extras.mujoco_engine.equal_blocks import is_equal


@dataclass(frozen=True, eq=False)
class Law:
    gains: np.ndarray

    @cached_property
    def largest(self):
        return self.gains.max()

    def output(self, value):
        return self.gains * value


class Scaled(ArrayBlock):
    def __init__(self, gain):
        super().__init__(0.1)
        self.gain = gain
        self.take("value", 1)
        self.put_out("scaled", self.scaled, "value")

    def scaled(self, value):
        return self.gain * value


def closure(gain):
    return lambda value: gain * value


def keyword_default(gain):
    def scaled(value, *, gain=gain):
        return gain * value

    return scaled


class WithoutField(Law):
    """A law with a value that is no field."""

    def __init__(self, gain):
        super().__init__(np.ones(2))
        object.__setattr__(self, "gain", gain)


def law(gain):
    return Law(np.array([1.0, gain]))


@pytest.mark.parametrize(
    "make",
    [
        closure,
        keyword_default,
        law,
        WithoutField,
        np.float64,
        lambda gain: partial(np.multiply, gain),
        lambda gain: law(gain).output,
        lambda gain: Scaled(gain).steps.outputs,
        lambda gain: {"gain": [gain, (np.nan, slice(1, 2))]},
    ],
)
def test_what_is_made_of_equal_values_is_equal(make):
    assert is_equal(make(2.0), make(2.0))
    assert not is_equal(make(2.0), make(3.0))


def test_values_are_equal_to_the_bit():
    assert not is_equal(0.0, -0.0)
    assert not is_equal(1, 1.0)
    assert not is_equal(np.zeros(2), np.zeros((2, 1)))


def test_what_holds_a_state_that_is_no_attribute_is_equal_to_itself_alone():
    one, other = Random(1), Random(1)
    assert is_equal(one, one)
    assert not is_equal(one, other)
