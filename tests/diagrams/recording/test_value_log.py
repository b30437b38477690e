"""ValueLog: keeps what is no vector, sample for sample, in the context."""

from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from soft_gripper.diagrams.signal_logs import ValueLog


class Clock(LeafSystem):
    """Puts the time out as a string."""

    def __init__(self):
        super().__init__()
        self.DeclareAbstractOutputPort("time", lambda: AbstractValue.Make(object()), self._calc)

    def _calc(self, context, value):
        value.set_value(f"{context.get_time():.1f}")


def test_values_are_kept_with_the_period_and_every_run_begins_anew():
    builder = DiagramBuilder()
    clock, log = builder.AddSystem(Clock()), builder.AddSystem(ValueLog(0.5))
    builder.Connect(clock.get_output_port(), log.get_input_port())
    diagram = builder.Build()
    for end, expected in ((1.2, ["0.0", "0.5", "1.0"]), (0.7, ["0.0", "0.5"])):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(end)
        assert log.values(simulator.get_context()) == expected
