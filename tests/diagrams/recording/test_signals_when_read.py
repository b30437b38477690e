"""Signals of a recording are computed when they are read, once, whatever is done with the recording before."""

from unittest.mock import patch

import numpy as np
import pytest

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = "estimator.type=contact", "sensor.sections=2", "pressure.steps.all=[60e3]", "pressure.settle=0.2"
POSTERIOR = "left_finger.contact_force_bounds", "left_finger.contact_probability"


@pytest.fixture(scope="module")
def recording():
    return simulate(load_scenario("free_bending", [*SHORT, "pressure.hold_samples=5"]))


def test_what_is_not_read_is_not_computed():
    with patch.object(ContactShape, "posterior", autospec=True, side_effect=ContactShape.posterior) as posterior:
        found = simulate(load_scenario("free_bending", [*SHORT, "pressure.hold_samples=5"]))
        assert np.isfinite(found["left_finger.tip_pose"].values).all()
        assert posterior.call_count == 0
        twice = [[found[name].values for name in POSTERIOR] for _ in range(2)]
        assert posterior.call_count == 1, "both follow from one posterior"
        np.testing.assert_array_equal(twice[0][1], twice[1][1])


@pytest.mark.parametrize("estimator", ["arcs", "contact"])
def test_a_run_computes_no_estimate(estimator):
    """Of a signal that nothing in the diagram takes."""
    scenario = load_scenario("free_bending", [*SHORT, "pressure.hold_samples=5", f"estimator.type={estimator}"])
    with patch.object(ArrayBlock, "output_over_time", autospec=True, side_effect=ArrayBlock.output_over_time) as output:
        found = simulate(scenario)
        assert output.call_count == 0
        assert np.isfinite(found["left_finger.tip_pose"].values).all()
        assert output.call_count > 0


@pytest.mark.parametrize("signal", ["estimated_joint_angles", "tip_pose", "external_torque"])
def test_an_estimate_without_readings_is_noted_when_it_is_read(signal, caplog):
    """Whichever of its signals that is, and once."""
    dead = "sensor.errors={dead: [{path: inner, section: 0}]}"
    found = simulate(load_scenario("free_bending", [*SHORT, "pressure.hold_samples=5", "estimator.type=arcs", dead]))
    assert np.isnan(found["left_finger.strain"].values).any()
    assert caplog.text == ""
    assert np.isnan(found[f"left_finger.{signal}"].values).all()
    said = "left_finger.estimated_joint_angles: NaN in 26 of 26 samples, first at t = 0 s"
    assert [record.getMessage() for record in caplog.records] == [said]
    found.data.load()
    assert [record.getMessage() for record in caplog.records if "left_finger" in record.getMessage()] == [said]
