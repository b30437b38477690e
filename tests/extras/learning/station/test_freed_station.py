"""The diagram of an environment is freed with its station."""

import gc
import weakref
from importlib.metadata import version

import pytest

from soft_gripper.extras.learning.config import load_environment
from soft_gripper.extras.learning.station import make_learning_station

OLD = tuple(map(int, version("drake").split(".")[:2])) < (1, 58)


@pytest.mark.slow
@pytest.mark.skipif(OLD, reason="older Drakes keep every diagram with blocks in Python")
def test_a_station_of_an_environment():
    environment = load_environment("soft_grasp")
    diagram = make_learning_station(environment.config, environment.scenario).diagram
    blocks = {block.get_name(): weakref.ref(block) for block in diagram.GetSystems()}
    del diagram
    gc.collect()
    assert [name for name, block in blocks.items() if block() is not None] == []
