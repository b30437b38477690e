"""What is observed: estimates, by their scales."""

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from refusals import refused

from soft_gripper.extras.learning.config import ObservedConfig
from soft_gripper.extras.learning.station import LARGEST, add_observation, scaled


def observe(*observed):
    builder = DiagramBuilder()
    values = {"finger.tip_pose": [0.1, 0.2, 0.3], "finger.contact_force": [np.nan], "plant.state": [1.0]}
    signals = {name: builder.AddSystem(ConstantVectorSource(value)).get_output_port() for name, value in values.items()}
    builder.ExportOutput(add_observation(builder, observed, signals), "observation")
    diagram = builder.Build()
    return diagram.GetOutputPort("observation").Eval(diagram.CreateDefaultContext())


def test_entries_are_chosen_and_scaled_in_order():
    pose = ObservedConfig("finger.tip_pose", [2, 0], 0.1)
    np.testing.assert_allclose(observe(ObservedConfig("finger.contact_force"), pose), [0.0, 3.0, 1.0])
    np.testing.assert_allclose(observe(ObservedConfig("finger.tip_pose")), [0.1, 0.2, 0.3])


def test_what_is_out_of_range_is_at_its_limit_and_what_is_unknown_is_zero():
    values = scaled(np.array([[1e9, -np.inf], [np.nan, 1.0]]), np.array([1.0, 2.0]))
    np.testing.assert_array_equal(values, [[LARGEST, -LARGEST], [0.0, 0.5]])


@pytest.mark.parametrize(
    ("observed", "field", "value"),
    [
        (ObservedConfig("plant.state"), "signal", "plant.state"),
        (ObservedConfig("finger.true_contact_force"), "signal", "finger.true_contact_force"),
        (ObservedConfig("finger.ideal_strain"), "signal", "finger.ideal_strain"),
        (ObservedConfig("finger.strain"), "signal", "finger.strain"),
        (ObservedConfig("finger.tip_pose", [3]), "entries", [3]),
    ],
)
def test_the_truth_and_what_is_not_there_are_refused(observed, field, value):
    with refused(field, value):
        observe(observed)
