"""Time since the beginning of a run, s: schedules count from there, so that a run may begin at any time."""

from collections.abc import Callable

from pydrake.systems.framework import Context, DiscreteStateIndex, LeafSystem, State


def declare_run_time(system: LeafSystem) -> Callable[[Context], float]:
    """Declares the state of a system that holds when a run began.

    It is taken when a run is initialized, before any discrete update. A run that goes on with the context of another,
    at a later time, goes on from the beginning of that.

    Returns:
        a function from the context of the system to the time since the run began, s; before a run, to the time.
    """
    offset = _declare_offset(system)
    return lambda context: context.get_time() + float(context.get_discrete_state(offset).value()[0])


class RunBegin(LeafSystem):
    """Puts out when a run began.

    ::

        +----------+
        | RunBegin | ---> offset (1) s, to be added to the time: minus the time at which the run began; 0 before a run
        +----------+
    """

    def __init__(self) -> None:
        super().__init__()
        self.DeclareStateOutputPort("offset", _declare_offset(self))


def _declare_offset(system: LeafSystem) -> DiscreteStateIndex:
    """Group of the discrete state with the offset that is added to the time, s."""
    offset, has_begun = system.DeclareDiscreteState([0.0]), system.DeclareDiscreteState([0.0])

    def begin(context: Context, state: State) -> None:
        goes_on = context.get_discrete_state(has_begun).value()[0] > 0
        time = context.get_time()
        if not goes_on or time + context.get_discrete_state(offset).value()[0] < 0:
            state.get_mutable_discrete_state(offset).set_value([-time])
            state.get_mutable_discrete_state(has_begun).set_value([1.0])

    system.DeclareInitializationUnrestrictedUpdateEvent(begin)
    return offset
