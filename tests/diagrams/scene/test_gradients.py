"""The plant has gradients, through contact too."""

from dataclasses import replace
from importlib.metadata import version

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.systems.framework import Diagram, DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.scenario.scenario_file import load_scenario


def _step(diagram: Diagram, state: Array) -> tuple[Array, int]:
    """The state after a step, and the number of contacts before it."""
    context = diagram.CreateDefaultContext()
    plant = diagram.GetSubsystemByName("plant")
    of_plant = plant.GetMyMutableContextFromRoot(context)
    plant.SetPositionsAndVelocities(of_plant, state)
    after = diagram.EvalUniquePeriodicDiscreteUpdate(context).value().copy().ravel()
    if after.dtype == object:
        return after, 0
    found = plant.get_contact_results_output_port().Eval(of_plant)
    return after, found.num_hydroelastic_contacts() + found.num_point_pair_contacts()


NEWER = tuple(map(int, version("drake").split(".")[:2])) >= (1, 58)
SURFACES = pytest.param("surface", marks=pytest.mark.skipif(not NEWER, reason="older Drakes have none of two boxes"))


@pytest.mark.parametrize("contact", [SURFACES, "points"])
def test_a_step_in_contact_against_differences(contact: str) -> None:
    scenario = load_scenario("box_grasp", ["pressure.settle=0.3"])
    state = simulate(scenario).data["plant.state"].values[-1]
    builder = DiagramBuilder()
    add_plant(builder, replace(scenario, contact=contact))
    diagram = builder.Build()
    assert _step(diagram, state)[1] > 0
    moves = 1e-7 * np.eye(len(state))
    numeric = np.transpose([(_step(diagram, state + h)[0] - _step(diagram, state - h)[0]) / 2e-7 for h in moves])
    exact = ExtractGradient(_step(diagram.ToAutoDiffXd(), InitializeAutoDiff(state).ravel())[0])
    assert np.abs(exact - numeric).max() < 1e-5 * np.abs(numeric).max()
