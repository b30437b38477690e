"""Commands from outside: input ports in the place of what a scenario commands, and signals of what comes in."""

import numpy as np
import pytest
from arm_plants import ur5e
from refusals import refused

from soft_gripper.diagrams.simulation import make_simulator, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

GAINS = "control.gains={kp: 1.0e5, ki: 5.7e6, kd: 17}"


def recorded(station, commands, duration):
    """What a station records under constant commands."""
    simulator = make_simulator(station)
    context = simulator.get_mutable_context()
    for name, value in commands.items():
        station.diagram.GetInputPort(name).FixValue(context, value)
    simulator.AdvanceTo(duration)
    return station.recording(context)


def arm_station(*external):
    scenario = ur5e()
    scenario.external = list(external)
    return make_station(scenario)


def test_pressures_come_from_outside():
    station = make_station(load_scenario("free_bending", ["external=[pressure]", "gravity=[0, 0, 0]"]))
    commands = {"left_finger.pressure_command": [50e3], "right_finger.pressure_command": [400e3]}
    assert list(station.parts.inputs) == list(commands)
    recording = recorded(station, commands, 1.5)
    for finger, pressure in zip(station.fingers, (50e3, station.scenario.pressure.maximum), strict=True):
        assert recording[f"{finger.name}.pressure"].values[-1] == pytest.approx(pressure, rel=1e-9)
        free = pressure * finger.finger.pressure_gain / finger.finger.stiffness
        np.testing.assert_allclose(recording[f"{finger.name}.sampled_joint_angles"].values[-1], free, rtol=2e-3)
    assert recording["right_finger.pressure_command"].values[-1] == 400e3
    assert recording["right_finger.pressure_command"].attrs["units"] == "Pa"


@pytest.mark.slow
def test_the_opening_comes_from_outside():
    station = make_station(
        load_scenario("tip_distance_steps", ["control.set_points=null", "external=[opening]", GAINS])
    )
    assert list(station.parts.inputs) == ["grip.set_point"]
    recording = recorded(station, {"grip.set_point": [0.06]}, 2.0)
    assert recording["grip.opening"].values[-1] == pytest.approx(0.06, abs=1e-4)
    assert (recording["grip.set_point"].values == 0.06).all()
    assert recording["grip.set_point"].attrs["units"] == "m"


@pytest.mark.parametrize("external", [["pressure"], ["joints"], ["tool"]])
def test_a_run_of_its_own_needs_every_command(external):
    station = arm_station(*external)
    with refused("external") as caught:
        run_station(station)
    assert all(name in str(caught.value) for name in station.parts.inputs)
