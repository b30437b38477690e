"""One seed for all random sources of a diagram, however deep."""

import numpy as np
import pytest
from pydrake.common import RandomDistribution
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import RandomSource

from soft_gripper.diagrams.simulation import seed_random_sources


@pytest.fixture(scope="module")
def nested():
    """A diagram with a source, and a diagram in it with another."""
    sources = [RandomSource(RandomDistribution.kGaussian, 2, 0.1) for _ in range(2)]
    inner, outer = DiagramBuilder(), DiagramBuilder()
    inner.AddSystem(sources[0])
    outer.AddSystem(inner.Build())
    outer.AddSystem(sources[1])
    diagram = outer.Build()

    def numbers(seed):
        context = diagram.CreateDefaultContext()
        seed_random_sources(diagram, context, seed)
        return [s.get_output_port().Eval(s.GetMyContextFromRoot(context)).tolist() for s in sources]

    return numbers


def test_a_seed_fixes_every_stream(nested):
    assert nested(4) == nested(4)
    assert not np.isin(nested(4), nested(5)).any()


def test_every_source_has_a_stream_of_its_own(nested):
    first, second = nested(4)
    assert not np.isin(first, second).any()
