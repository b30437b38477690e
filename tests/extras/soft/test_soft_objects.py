"""Scenarios with soft objects: what does not go with them is refused, and a grasp is simulated, recorded and judged."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from refusals import refused

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import advance, run_to_end
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.runs.scores.recorded_grasps import recorded_grasps
from soft_gripper.runs.scores.recorded_task import TaskRun
from soft_gripper.scenario.scenario_file import load_scenario

SPONGE = "pick_and_place_sponge"


@pytest.mark.parametrize(
    ("override", "field", "value"),
    [
        ("plant_config.time_step=0", "time_step", 0),
        ("contact=points", "contact", "points"),
        ("models.2.half_space=true", "half_space", True),
        (f"models.3.file={'package://soft_gripper/objects/box.obj'}", "mesh.youngs_modulus", 2e4),
    ],
)
def test_what_does_not_go_with_a_soft_object_is_refused(override, field, value):
    with refused(field, value):
        make_station(load_scenario(SPONGE, [override]))


def test_other_approximations_of_contact_are_warned_of(caplog):
    make_station(load_scenario(SPONGE, ["plant_config.discrete_contact_approximation=lagged"]))
    assert "discrete_contact_approximation" in caplog.text


def test_a_crushed_object_is_an_error():
    station = make_station(load_scenario(SPONGE))
    simulator = Simulator(station.diagram)
    context = station.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    soft = station.parts.deformables["sponge"]
    soft.body.SetPositions(context, soft.rest.vertices.T * np.array([[1.0], [1.0], [-1.0]]))
    with pytest.raises(SimulationDivergedError, match="sponge"):
        advance(simulator, station, 1e-4)


@pytest.fixture(scope="module")
def lifted() -> tuple[Station, Recording]:
    """A sponge that has been lifted and held for a while, in long steps."""
    scenario = load_scenario(SPONGE, ["plant_config.time_step=0.01", "task.phases.3.rest=0.8"])
    phases = scenario.task.phases[:4]  # it is held at the end of the last of them
    station = make_station(replace(scenario, task=replace(scenario.task, phases=phases)))
    return station, station.recording(run_to_end(station).get_context())


@pytest.mark.slow
def test_a_lifted_sponge_is_held_by_forces_that_carry_it(lifted):
    station, recording = lifted
    (grasp,), grips = recorded_grasps(station, recording)
    assert grasp.grasp == "held"
    assert {grip.finger for grip in grips} == {"left_finger", "right_finger"}
    carried = recording["sponge.grip_force"].values[-30:].sum(axis=1).mean(axis=0)
    wrench = recording["sponge.contact_wrench"].values[-30:, 3:].mean(axis=0)
    np.testing.assert_allclose(carried, wrench, atol=1e-9)  # nothing else touches it
    assert wrench[2] == pytest.approx(0.016 * 9.81, rel=0.01)


@pytest.mark.slow
def test_a_lifted_sponge_is_squeezed_and_rises_with_the_gripper(lifted):
    station, recording = lifted
    task = TaskRun(station, recording)
    assert np.ptp(recording["sponge.pose"].values[:, 6]) == pytest.approx(0.1, abs=2e-3)
    assert 0.5e-3 < task.squeeze < 2e-3
    assert recording["sponge.largest_strain"].values.max() > task.squeeze / 0.044  # more than the mean over its width
    assert task.slip < 2e-3


SDF = """<sdf version="1.7"><model name="jelly"><link name="jelly">
  <collision name="elements"><geometry><mesh><uri>package://soft_objects/objects/soft_block.vtk</uri></mesh></geometry>
    <drake:proximity_properties xmlns:drake="http://drake.mit.edu"><drake:mu_dynamic>0.8</drake:mu_dynamic>
    </drake:proximity_properties></collision>
  <drake:deformable_properties xmlns:drake="http://drake.mit.edu"><drake:youngs_modulus>2e4</drake:youngs_modulus>
    <drake:poissons_ratio>0.3</drake:poissons_ratio><drake:mass_density>150</drake:mass_density>
  </drake:deformable_properties></link>{}</model></sdf>"""


def test_an_sdf_file_of_finite_elements_is_a_soft_object(tmp_path):
    (tmp_path / "jelly.sdf").write_text(SDF.format(""))
    station = make_station(load_scenario("box_grasp", [f"models.2.file={tmp_path / 'jelly.sdf'}"]))
    soft = station.parts.deformables["box"]
    assert soft.mass == pytest.approx(150 * 0.044 * 0.04 * 0.06)
    recorded = {f"box.{signal}" for signal in ("pose", "vertices", "squeeze", "largest_strain", "contact_wrench")}
    assert recorded <= set(station.logs.signals)
