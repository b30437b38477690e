"""One seed for all random sources of a diagram, however deep."""

import re

import numpy as np
import pytest
from pydrake.common import RandomDistribution
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import RandomSource

import soft_gripper as sg
from soft_gripper.diagrams.simulation import seed_random_sources
from soft_gripper.scenario.model_files import model_path


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


def test_every_source_has_a_stream_of_its_own(nested):
    first, second = nested(4)
    assert not np.isin(first, second).any()


def test_sensors_of_a_finger_err_alike_wherever_it_stands_in_the_file(tmp_path):
    text = model_path("package://soft_gripper/grippers/two_finger.urdf").read_text()
    swapped = re.sub(r"(<finger .*?</finger>)(\s*)(<finger .*?</finger>)", r"\3\2\1", text, flags=re.DOTALL)
    read = []
    for number, model in enumerate((text, swapped)):
        file = tmp_path / f"{number}.urdf"
        file.write_text(model)
        changes = "sensor.errors.preset=realistic", "pressure.settle=0.1", "pressure.steps.all=[5e4]"
        read.append(sg.simulate(sg.load_scenario("box_grasp", [f"models.0.file={file}", *changes])))
    for signal in ("left_finger.strain", "right_finger.strain"):
        np.testing.assert_allclose(*(recording[signal] for recording in read), atol=1e-12)
