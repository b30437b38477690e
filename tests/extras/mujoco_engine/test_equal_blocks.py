"""Blocks are equal by what their functions hold."""

from dataclasses import dataclass
from functools import cached_property, partial
from random import Random

import numpy as np
import pytest
from drake_plants import DrakePlants
from pydrake.math import BarycentricMesh
from pydrake.systems.primitives import BarycentricMeshSystem, Gain, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.mujoco_engine.blocks import PerDiagram, contents
from soft_gripper.extras.mujoco_engine.equal_blocks import is_equal
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.scenario.scenario_file import changed_scenario


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


def line(slope, end=2.0):
    return TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, 1.0, end], [[0.0, 1.0, 1.0 + slope]]))


def table(values):
    return BarycentricMeshSystem(BarycentricMesh([{0.0, 1.0}]), np.array([values]))


def test_sources_and_tables_of_drake_are_compared_by_their_values():
    times = np.array([[0.0], [1.2]])
    assert is_equal(contents(line(2.0), times), contents(line(2.0), times))
    assert not is_equal(contents(line(2.0), times), contents(line(3.0), times))
    assert not is_equal(contents(table([1.0, 2.0]), times), contents(table([1.0, 3.0]), times))
    assert is_equal(contents(table([1.0, 2.0]), times), contents(table([1.0, 2.0]), times))
    one = Gain(2.0, 1)
    assert contents(one, times) is one


def test_stations_with_other_pressures_share_the_source_of_steps():
    stations = [
        make_private_station(changed_scenario("free_bending", {"pressure.steps.all": [p]}), composed=False)
        for p in (50e3, 60e3)
    ]
    network = Network(stations, DrakePlants(stations[0]), stations[0].logs)
    assert not any(isinstance(block, PerDiagram) for block in network._blocks.values())
