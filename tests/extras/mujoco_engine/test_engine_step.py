"""The runs of a sweep, of trials or of a design share the step of their engine, which suits their scenario."""

import pytest
from here_executor import HereExecutor

from soft_gripper.extras.mujoco_engine import engine
from soft_gripper.runs.sweep.measured_runs import engine_step_of

ENGINE = {"engine": "mujoco"}


@pytest.fixture
def suited(monkeypatch):
    """The scenarios for which a step was chosen."""
    asked = []

    def suited_step(scenario):
        asked.append(scenario)
        return 0.0025

    monkeypatch.setattr(engine, "suited_step", suited_step)
    return asked


def test_the_step_suits_the_scenario_with_what_all_runs_change(suited):
    fixed = ENGINE | {"sensor.period": 0.02}
    assert engine_step_of("free_bending", fixed, HereExecutor()) == {"engine_step": 0.0025}
    assert [scenario.sensor.period for scenario in suited] == [0.02]


@pytest.mark.parametrize("fixed", [{}, ENGINE | {"engine_step": 0.001}])
def test_no_step_is_chosen_in_drake_or_if_one_is_given(suited, fixed):
    assert engine_step_of("free_bending", fixed, HereExecutor()) == {}
    assert not suited
