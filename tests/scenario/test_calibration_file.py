"""Calibration files: written, read again, applied, and refused."""

import re
from dataclasses import asdict, replace

import numpy as np
import pytest
import yaml
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.scenario.calibration_file import (
    CalibrationConfig,
    FingerCalibrationConfig,
    apply_calibration,
    layout_identity,
    load_calibration,
)
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.scenario.schema import EstimatorConfig, SensorConfig, UncertaintyConfig
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.fixture
def layout(tapered_finger):
    return SensorLayout(tapered_finger, 2)


@pytest.fixture
def calibration(layout):
    rows = np.arange(21.0).reshape(3, 7).tolist()
    names = [f"number {i}" for i in range(7)]
    fitted = FittedStatesConfig(names, [1.0] * 7, rows, [1e-3], growth=2e-3, noise=0.05, disagreement=0.2)
    own = {"gains": [1.1, 0.9, 1.0, 1.0], "offsets": [0.01, 0.0, 0.0, -0.01], "response_curvature": -0.1}
    finger = FingerCalibrationConfig(
        *layout_identity(layout), 1.25, **own, pressure_offset=300.0, bend_ratio_std=0.02, fitted=fitted
    )
    return CalibrationConfig("in words", {"tapered": finger})


def save_calibration(calibration, path):
    path.write_text(yaml.safe_dump(asdict(calibration)))


def test_what_is_written_is_read_again(calibration, tmp_path):
    save_calibration(calibration, tmp_path / "file.yaml")
    assert load_calibration(str(tmp_path / "file.yaml")) == calibration


def test_it_changes_what_is_believed(layout, calibration):
    """Softer by the ratio, driven by less pressure than is read, and the response of every sensor."""
    nominal = apply_calibration(layout, calibration)
    np.testing.assert_allclose(nominal.finger.stiffness, layout.finger.stiffness / 1.25, rtol=1e-12)
    np.testing.assert_allclose(nominal.finger.pressure_gain, layout.finger.pressure_gain, rtol=1e-12)
    torque = layout.finger.pressure_torque(np.array([49.7e3]))
    np.testing.assert_allclose(nominal.finger.pressure_torque(np.array([50e3])), torque, rtol=1e-12)
    expected = np.array([1.1, 0.9, 1.0, 1.0]) * (0.1 - 0.1 * 0.1**2) + [0.01, 0.0, 0.0, -0.01]
    np.testing.assert_allclose(nominal.response.reading(np.full(4, 1.1)), expected)


def test_the_states_of_a_calibration_are_those_that_were_kept(layout, calibration, tmp_path):
    save_calibration(calibration, tmp_path / "file.yaml")
    states = apply_calibration(layout, load_calibration(str(tmp_path / "file.yaml"))).calibrated
    assert states is not None
    assert sorted(states.fitted.states[:, 0]) == [0.0, 7.0, 14.0]
    assert (states.widths.growth, states.disagreement, states.noise) == (2e-3, 0.2, 0.05)
    assert states.bend_std == 0.02 / 1.25


def test_a_strength_leaves_the_bend_under_pressure_and_a_variation_its_middle(layout, calibration):
    """Of measured forces: by 1.2 stiffer, and driven as much more, by a pressure of 50 kPa less its offset."""
    before, stronger, graded = (
        apply_calibration(
            layout, CalibrationConfig("", {"tapered": replace(calibration.fingers["tapered"], **change)})
        ).finger
        for change in ({}, {"strength": 1.2}, {"bend_variation": 0.1})
    )
    torque = stronger.pressure_torque(np.array([50e3]))
    np.testing.assert_allclose(torque, 1.2 * before.pressure_torque(np.array([50e3])), rtol=1e-12)
    np.testing.assert_allclose(stronger.stiffness, 1.2 * before.stiffness, rtol=1e-12)
    softer = graded.stiffness / before.stiffness
    assert np.all(np.diff(softer) < 0)
    assert softer[2] == pytest.approx(1, rel=0.02)


def test_what_a_calibration_leaves_is_what_estimators_assume(layout, calibration):
    """Unless the scenario says otherwise; a file that does not say leaves the default of a finger not calibrated."""
    says = replace(calibration.fingers["tapered"], bend_gain_std=3e-3, hysteresis=4e-3, bend_variation_std=0.03)
    states = apply_calibration(layout, CalibrationConfig("", {"tapered": says})).calibrated
    found = uncertainty(EstimatorConfig(), SensorConfig(), states)
    assert (found.gain, found.bend_per_pressure) == (pytest.approx(5e-3), EXACT)
    assert found.bend_stds[1] == 0
    given = EstimatorConfig(uncertainty=UncertaintyConfig(bend_per_pressure=0.02))
    assert uncertainty(given, SensorConfig(), states).bend_per_pressure == 0.02
    silent = apply_calibration(layout, calibration).calibrated
    assert uncertainty(EstimatorConfig(), SensorConfig(), silent) == Uncertainty()
    q, along = np.full(5, 0.1), np.linspace(-0.8, 0.8, 5)
    finger = replace(layout.finger, segments=5)
    scale = Mechanics(replace(layout, finger=finger, calibrated=states), Uncertainty()).scale_covariance(q)
    np.testing.assert_allclose(scale, (0.016**2 + 0.03**2 * np.outer(along, along)) * 0.01, rtol=1e-12)


@pytest.mark.parametrize("other", ["name", "length", "sections", "one_sided", "borders"])
def test_another_finger(layout, calibration, other):
    if other in ("name", "length"):
        value = {"name": "other", "length": 0.13}[other]
        layout = replace(layout, finger=replace(layout.finger, **{other: value}))
    else:
        layout = replace(layout, **{other: (0.25,) if other == "borders" else 1})
    with pytest.raises(InputError) as caught:
        apply_calibration(layout, calibration)
    assert caught.value.where == "nominal.calibration"


def test_every_gain_has_an_offset(calibration, tmp_path):
    calibration.fingers["tapered"].offsets.pop()
    save_calibration(calibration, tmp_path / "file.yaml")
    with refused("fingers.tapered.offsets", [0.01, 0.0, 0.0]):
        load_calibration(str(tmp_path / "file.yaml"))


@pytest.mark.parametrize(
    ("field", "value", "named"),
    [
        ("states[1][2]", float("nan"), "fitted.states[1][2]"),
        ("spread[0]", 0.0, "fitted.spread[0]"),
        ("spread", [1.0], "fitted.spread"),
        ("disagreement", -0.1, "fitted.disagreement"),
        ("names", ["a", "b"], "fitted.spread"),
    ],
)
def test_states_that_cannot_be_are_refused(calibration, tmp_path, field, value, named):
    save_calibration(calibration, tmp_path / "file.yaml")
    document = yaml.safe_load((tmp_path / "file.yaml").read_text())
    *into, last = re.findall(r"\w+", field)
    at = document["fingers"]["tapered"]["fitted"]
    for key in into:
        at = at[int(key) if key.isdigit() else key]
    at[int(last) if last.isdigit() else last] = value
    (tmp_path / "file.yaml").write_text(yaml.safe_dump(document))
    with refused(f"fingers.tapered.{named}"):
        load_calibration(str(tmp_path / "file.yaml"))
