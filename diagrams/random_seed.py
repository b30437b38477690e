"""One seed for all random numbers of a diagram."""

from collections.abc import Iterator

from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.primitives import RandomSource


def seed_random_sources(diagram: Diagram, context: Context, seed: int) -> None:
    """Gives every RandomSource in a diagram a stream of its own, that follows from one seed, 0 or more.

    A source in Python has no other way to a fixed seed: a default context holds one that differs from instance to
    instance. Call it before `Simulator.Initialize`, in which the draws for a run are made.

    Args:
        diagram: which may hold diagrams.
        context: of the diagram, or of one that holds it.
        seed: of the run.
    """
    generator = RandomGenerator(seed)
    for source in _random_sources(diagram):
        source.SetRandomContext(source.GetMyMutableContextFromRoot(context), generator)


def _random_sources(diagram: Diagram) -> Iterator[RandomSource]:
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _random_sources(system)
        elif isinstance(system, RandomSource):
            yield system
