"""Diagrams are freed with their stations, whatever blocks are in them."""

import gc
import weakref
from importlib.metadata import version

import pytest
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from soft_gripper.cached import Cached, weakly
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

OLD = tuple(map(int, version("drake").split(".")[:2])) < (1, 58)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(OLD, reason="older Drakes keep every diagram with blocks in Python"),
]

NOISY = ["sensor.errors.preset=realistic", "sensor.sections=2", "estimator.contact_threshold=2.5e-3"]
SHORT = ["pressure.settle=0.05", "pressure.hold_samples=1"]


def blocks_of(diagram):
    """All blocks of a diagram, at every depth, held weakly, by their names."""
    found = {}
    for block in diagram.GetSystems():
        found[block.get_name()] = weakref.ref(block)
        if isinstance(block, Diagram):
            found |= blocks_of(block)
    return found


def alive(blocks):
    gc.collect()
    return [name for name, block in blocks.items() if block() is not None]


@pytest.mark.parametrize(
    ("name", "overrides"),
    [("box_grasp", [*NOISY, "estimator.alongside=[spline, contact, recursive]"]), ("pick_and_place_box", [])],
)
def test_a_station(name, overrides):
    blocks = blocks_of(make_station(load_scenario(name, overrides)).diagram)
    assert len(blocks) > 20
    assert alive(blocks) == []


def test_a_station_that_has_run():
    station = make_station(load_scenario("free_bending", SHORT))
    recording = run_station(station)
    blocks = blocks_of(station.diagram)
    del station
    assert alive(blocks) == []
    assert len(recording["time"]) > 1


class Block(LeafSystem):
    """Remembers what it has computed."""

    def __init__(self, is_weak):
        super().__init__()
        value = self.DeclareVectorInputPort("value", 1)
        self._cached = Cached(self, "twice", weakly(self._calc) if is_weak else self._calc, {value.ticket()})

    def _calc(self, context):
        return 2 * self.get_input_port().Eval(context)


@pytest.mark.parametrize("is_weak", [True, False])
def test_a_block_with_a_cache(is_weak):
    builder = DiagramBuilder()
    block = builder.AddNamedSystem("block", Block(is_weak))
    builder.ExportInput(block.get_input_port())
    blocks = blocks_of(builder.Build())
    del builder, block
    assert alive(blocks) == ([] if is_weak else ["block"])
