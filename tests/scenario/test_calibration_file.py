"""Calibration files: written, read again, applied, and refused."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration import Calibration
from soft_gripper.scenario.calibration_file import (
    CalibrationConfig,
    as_config,
    calibrated,
    load_calibration,
    save_calibration,
)
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.fixture
def layout(tapered_finger):
    return SensorLayout(tapered_finger, 2)


@pytest.fixture
def calibration(layout):
    gains, offsets, stds = np.array([1.1, 0.9, 1.0, 1.0]), np.array([0.01, 0.0, 0.0, -0.01]), np.full(4, 1e-3)
    known = True, ((0, 2.5),), 300.0, 50.0, -0.1, 0.02
    found = Calibration(1.25, gains, offsets, 1e-3, 0.02, 5 * stds, stds, 0.01, 1e-2 * stds, *known)
    return CalibrationConfig("in words", {"tapered": as_config(layout, found, ["log.csv at 2.5 s"])})


def test_what_is_written_is_read_again(calibration, tmp_path):
    save_calibration(calibration, tmp_path / "file.yaml")
    assert load_calibration(str(tmp_path / "file.yaml")) == calibration


def test_it_changes_what_is_believed(layout, calibration):
    """Softer by the ratio, driven by less pressure than is read, and the response of every sensor."""
    nominal = calibrated(layout, calibration)
    np.testing.assert_allclose(nominal.finger.stiffness, layout.finger.stiffness / 1.25, rtol=1e-12)
    np.testing.assert_allclose(nominal.finger.pressure_gain, layout.finger.pressure_gain, rtol=1e-12)
    torque = layout.finger.pressure_torque(np.array([49.7e3]))
    np.testing.assert_allclose(nominal.finger.pressure_torque(np.array([50e3])), torque, rtol=1e-12)
    expected = np.array([1.1, 0.9, 1.0, 1.0]) * (0.1 - 0.1 * 0.1**2) + [0.01, 0.0, 0.0, -0.01]
    np.testing.assert_allclose(nominal.response.reading(np.full(4, 1.1)), expected)


@pytest.mark.parametrize("other", ["name", "length", "sections", "one_sided", "borders"])
def test_another_finger(layout, calibration, other):
    if other in ("name", "length"):
        value = {"name": "other", "length": 0.13}[other]
        layout = replace(layout, finger=replace(layout.finger, **{other: value}))
    else:
        layout = replace(layout, **{other: (0.25,) if other == "borders" else 1})
    with pytest.raises(InputError) as caught:
        calibrated(layout, calibration)
    assert caught.value.where == "nominal.calibration"


@pytest.mark.parametrize(
    ("field", "value", "wrong"),
    [
        ("bend_ratio", -1.0, "bend_ratio"),
        ("gains", [1.0, 0.0, 1.0, 1.0], "gains[1]"),
        ("offsets", [0.0], "offsets"),
        ("gain", 1.0, "gain"),
    ],
)
def test_what_cannot_be(calibration, tmp_path, field, value, wrong):
    path = tmp_path / "file.yaml"
    save_calibration(calibration, path)
    document = yaml.safe_load(path.read_text())
    document["fingers"]["tapered"][field] = value
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError) as caught:
        load_calibration(str(path))
    assert caught.value.field == f"fingers.tapered.{wrong}"


@pytest.mark.parametrize(
    ("text", "field", "value"), [(None, "file", "file.yaml"), ("a: [", "file", "file.yaml"), ("3", "", 3)]
)
def test_no_calibration(tmp_path, text, field, value):
    path = tmp_path / "file.yaml"
    if text is not None:
        path.write_text(text)
    with refused(field, value):
        load_calibration(str(path))
