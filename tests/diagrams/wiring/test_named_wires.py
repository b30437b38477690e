"""Blocks wired by the names of their ports."""

from pydrake.common.value import Value
from pydrake.systems.framework import Diagram, LeafSystem
from pydrake.systems.primitives import Gain

from soft_gripper.diagrams.wiring.named_wires import NamedWires, inputs, vector_outputs
from soft_gripper.signals import describe


class Sum(LeafSystem):
    """One number from the sum of others; besides, something that is no vector."""

    def __init__(self, output, *names, unit="1"):
        super().__init__()
        ports = [self.DeclareVectorInputPort(name, 1) for name in names]
        total = self.DeclareVectorOutputPort(
            output, 1, lambda context, value: value.SetFromVector(sum(port.Eval(context) for port in ports))
        )
        describe(total, unit)
        self.DeclareAbstractOutputPort("object", lambda: Value("none"), lambda context, value: None)


class Wired(Diagram):
    def __init__(self, *blocks):
        """Blocks as (name, system, renamed, later)."""
        super().__init__()
        wires = NamedWires()
        for block in blocks:
            wires.add(*block)
        wires.build_into(self)


def evaluate(diagram, **values):
    context = diagram.CreateDefaultContext()
    for name, value in values.items():
        diagram.GetInputPort(name).FixValue(context, [value])
    return {name: port.Eval(context)[0] for name, port in vector_outputs(diagram).items()}


def test_but_an_input_may_wait_for_a_block_behind():
    diagram = Wired(("first", Sum("d", "c", "a"), None, {"c"}), ("second", Sum("c", "a")))
    assert list(inputs(diagram)) == ["a"]
    assert evaluate(diagram, a=1.0) == {"d": 2.0, "c": 1.0}


def test_of_two_outputs_of_one_name_the_first_is_taken():
    diagram = Wired(("first", Sum("c", "a")), ("second", Sum("c", "b")), ("third", Sum("d", "c")))
    assert evaluate(diagram, a=1.0, b=2.0) == {"c": 1.0, "d": 1.0}


def test_ports_may_have_other_names_in_the_diagram():
    diagram = Wired(("gain", Gain(3.0, 1), {"u0": "a", "y0": "b"}), ("sum", Sum("c", "b", "a")))
    assert evaluate(diagram, a=2.0) == {"b": 6.0, "c": 8.0}
