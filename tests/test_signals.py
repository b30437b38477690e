"""What ports declare about themselves, and that it stays with them."""

import gc

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough

from soft_gripper.signals import XZ, Signal, describe, export_outputs, signal_of


def port(size):
    return PassThrough(size).get_output_port()


def test_unit_and_axes_are_those_declared():
    positions = port(6)
    assert describe(positions, "m", joint=range(3), xz=XZ) is positions
    assert signal_of(positions) == Signal("m", {"joint": range(3), "xz": XZ})
    assert list(signal_of(positions).axes) == ["joint", "xz"]


def test_what_is_not_declared_has_no_unit_and_is_counted():
    assert signal_of(port(3)) == Signal(axes={"entry": range(3)})
    assert signal_of(port(1)) == Signal()


@pytest.mark.parametrize(
    ("axes", "message"), [({}, r"give axes for its entries"), ({"time": range(2)}, "is the axis of")]
)
def test_axes_are_given_and_not_that_of_the_samples(axes, message):
    with pytest.raises(ValueError, match=message):
        describe(port(2), **axes)


@pytest.mark.parametrize(("size", "axes"), [(5, {"joint": range(3)}), (6, {"joint": range(2), "xz": XZ})])
def test_axes_fill_the_port(size, axes):
    with pytest.raises(ValueError, match=rf"port 'y': axes of \d entries for {size} in the port"):
        describe(port(size), "m", **axes)


@pytest.mark.parametrize(("units", "axes"), [(("m", "m"), {"pose": range(3)}), (("m",), {})])
def test_units_fill_the_last_axis(units, axes):
    with pytest.raises(ValueError, match=f"port 'y': {len(units)} units do not fit its last axis"):
        describe(port(3 if axes else 1), units, **axes)


def test_a_diagram_carries_what_the_ports_inside_do():
    """Also those of Drake's own blocks, of which nothing in Python is kept."""
    builder = DiagramBuilder()
    block = builder.AddNamedSystem("block", PassThrough(2))
    describe(block.get_output_port(), "m", xz=XZ)
    builder.ExportOutput(block.get_output_port(), "tip")
    builder.ExportOutput(block.get_output_port(), "again")
    diagram = builder.Build()
    export_outputs(diagram, {"tip": block.get_output_port()})
    del builder, block
    gc.collect()
    assert signal_of(diagram.GetOutputPort("tip")) == Signal("m", {"xz": XZ})
    assert signal_of(diagram.GetOutputPort("again")) == Signal(axes={"entry": range(2)})
    assert signal_of(diagram.GetSubsystemByName("block").get_output_port()) == Signal("m", {"xz": XZ})
