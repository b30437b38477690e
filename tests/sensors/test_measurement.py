"""Sensors of another kind: a class in one file, shown in docs/sensors.md, and the estimators that take its matrix."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import SENSORS, sensor_layout
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.path_sensors import LAYOUTS
from soft_gripper.sensors.sensor_layout import SensorLayout

TEXT = (Path(__file__).parents[2] / "docs/sensors.md").read_text(encoding="utf-8")
(CODE,) = re.findall(r"```python\n(# my_sensors.py\n.*?)```", TEXT, re.DOTALL)
CODE += '''

class LinkAngles(sg.sensors.MeasurementModel):
    """Inclination of the link at the end of every section."""

    quantity, unit = "link_angle", "rad"

    @cached_property
    def matrix(self):
        return (np.arange(self.finger.segments) < self.section_ends[1:, None]).astype(float)
'''
KINDS = {"FiberGratings": ("curvature", "rad/m"), "LinkAngles": ("link_angle", "rad")}
LINEAR = ("spline", "gaussian", "contact", "recursive")


@pytest.fixture(params=KINDS)
def kind(request, tmp_path, monkeypatch):
    (tmp_path / "my_sensors.py").write_text(CODE)
    monkeypatch.chdir(tmp_path)
    return f"my_sensors:{request.param}"


def run(kind, estimator, *overrides):
    steps = "pressure.steps={all: [0, 6e4]}", "pressure.hold_samples=10"
    settings = f"sensor.type={kind}", f"estimator.type={estimator}", *steps, *overrides
    return simulate(load_scenario("obstructed_inside", settings))


def test_readings_are_those_of_the_chain(kind, shipped_finger, bent):
    layout, q = sensor_layout(shipped_finger, SensorConfig(type=kind, sections=4)), bent(5, 12)
    headings, ds = q.cumsum(axis=-1), shipped_finger.segment_length
    expected = headings[:, 2::3] if kind.endswith("Angles") else q[:, 1::3] / ds
    np.testing.assert_allclose(layout.read(q), expected, atol=1e-12)
    np.testing.assert_allclose(layout.predict(q), q @ layout.jacobian.T, atol=1e-15)


@pytest.mark.parametrize("name", LINEAR)
def test_free_bending_is_estimated(kind, name, shipped_finger):
    layout = sensor_layout(shipped_finger, SensorConfig(type=kind, sections=4))
    pressure = np.array([0.0, 50e3, 150e3])
    q, driving = free_bending_angles(shipped_finger, pressure), shipped_finger.pressure_torque(pressure)
    shape = SHAPE_FUNCTIONS[name](layout, Uncertainty())(layout.read(q), driving, np.zeros(3))
    np.testing.assert_allclose(shape.q, q, atol=5e-3)


@pytest.mark.slow
def test_a_scenario_names_them(kind):
    """Three estimators side by side; the readings with unit, axis and errors of their own."""
    quantity, unit = KINDS[kind.partition(":")[2]]
    ideal = run(kind, "gaussian", "estimator.alongside=[spline,recursive]")
    assert ideal[f"left_finger.{quantity}"].attrs["units"] == unit
    assert ideal[f"left_finger.{quantity}"].sizes["sensor"] == 4
    for name, limit in (("", 1e-4), ("spline.", 1e-3), ("recursive.", 1e-3)):
        assert float(ideal[f"left_finger.{name}pose_error"][-1]) < limit
    noisy = run(kind, "gaussian", "sensor.errors.noise=0.02")
    error = (noisy[f"left_finger.{quantity}"] - noisy[f"left_finger.ideal_{quantity}"]).values
    assert error.std() == pytest.approx(0.02, rel=0.2)
    assert float(noisy["left_finger.pose_error"][-1]) > float(ideal["left_finger.pose_error"][-1])


@pytest.mark.parametrize("name", ["arcs", "constant_curvature"])
def test_arcs_are_made_of_strain(kind, name):
    with pytest.raises(InputError) as error:
        run(kind, name)
    assert (error.value.field, error.value.value) == ("sensor.type", KINDS[kind.partition(":")[2]][0])


def test_what_they_do_not_have_is_refused(kind, shipped_finger):
    with pytest.raises(InputError) as error:
        sensor_layout(shipped_finger, SensorConfig(type=kind, one_sided=True))
    assert error.value.field == "one_sided"
    for field in ("errors.dead", "faults"):
        for path in ("inner", "outer"):
            with pytest.raises(InputError, match="has no paths") as error:
                run(kind, "gaussian", f"sensor.{field}=[{{path: {path}, section: 1}}]")
            assert (error.value.field, error.value.value) == (f"{field}[0].path", path)


@pytest.mark.parametrize("matrix", [np.ones((2, 11)), np.ones(12), np.full((2, 12), np.nan), np.empty((0, 12))])
def test_a_matrix_that_does_not_fit_is_refused(shipped_finger, matrix):
    class Wrong(MeasurementModel):
        quantity, unit = "wrong", "1"

        @property
        def matrix(self):
            return matrix

    with pytest.raises(InputError) as error:
        Wrong(shipped_finger, 2)
    assert error.value.field == "matrix of Wrong"


OF_THE_PROJECT = [SensorConfig(type=kind, sections=3) for kind in SENSORS]
OF_THE_PROJECT += [SensorConfig(sections=3, one_sided=True), *(SensorConfig(layout=name) for name in LAYOUTS)]


@pytest.mark.parametrize("ways", [("bending",), YIELDS], ids=["in the plane", "in space"])
@pytest.mark.parametrize("config", OF_THE_PROJECT, ids=lambda config: f"{config.type} {config.layout}")
def test_slopes_are_the_derivatives_of_what_is_read(shipped_finger, bent, config, ways):
    """About the straight finger, and about bent ones of sensors whose slopes depend on the bend."""
    layout = sensor_layout(replace(shipped_finger, yields=ways), config)
    bends = () if isinstance(layout, SensorLayout) else 0.05 * bent(2, len(layout.straight))
    for q in (layout.straight, *bends):
        steps = 1e-6 * np.eye(len(q))
        differences = [(layout.predict(q + dq) - layout.predict(q - dq)) / 2e-6 for dq in steps]
        slopes = np.broadcast_to(layout.slopes(q), (layout.readings, len(q)))
        np.testing.assert_allclose(slopes, np.stack(differences, axis=-1), rtol=1e-5, atol=2e-7)
    np.testing.assert_allclose(layout.jacobian, layout.slopes(layout.straight), atol=1e-15)
