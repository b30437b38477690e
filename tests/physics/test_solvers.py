"""The two solvers agree, and what cannot be simulated says so."""

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.fingers.kinematics import forward_kinematics


def settled_tips(*overrides):
    """Both fingertips at the end of two pressures, m in their B, complex."""
    station = make_station(free_bending([150e3, 200e3], 1.0, *overrides))
    recording = simulate(station.scenario)
    return np.array(
        [
            forward_kinematics(angles.sel(time=[1.0, 2.0]).values, finger.finger.segment_length).tip
            for finger in station.fingers
            for angles in [recording[f"{finger.name}.sampled_joint_angles"]]
        ]
    )


@pytest.mark.slow
def test_cenic_and_discrete_plant_settle_at_the_same_tip():
    continuous = settled_tips("plant_config.time_step=0")
    for time_step in (0.01, 0.002):
        discrete = settled_tips(f"plant_config.time_step={time_step}")
        assert np.abs(discrete - continuous).max() < 1e-4


def test_infeasible_time_step_is_refused_with_both_numbers():
    scenario = free_bending([0.0], 0.1, "plant_config.time_step=0.0135")
    limit = r"0\.0135: .*stable_time_step\(\) = 0\.013 s of finger 'left_finger'"
    with pytest.raises(InputError, match=limit):
        make_station(scenario)


def test_divergence_names_time_state_and_cause():
    explicit = (
        "plant_config.time_step=0",
        "simulator_config.integration_scheme=explicit_euler",
        "simulator_config.use_error_control=false",
    )
    with pytest.raises(SimulationDivergedError) as caught:
        simulate(free_bending([150e3], 1.0, *explicit))
    message = str(caught.value)
    assert "the simulation diverged before t = 0." in message
    assert "in state left_finger_" in message
    assert "likely cause: a time step too long" in message
