"""Measures of a design's sensors and strength, from a station and a recording made up of what they read."""

from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.design import measures
from soft_gripper.extras.design.measures import force_error_n, sensors, strength_n
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import DRAKE, Scenario, SensorConfig

FINGERS = expand_urdf(DIRECTORY / "grippers/two_finger.urdf").fingers


class FakeRecording(dict):
    """Signals by name."""

    @property
    def data(self):
        return self


def station(**sensor):
    scenario = Scenario(sensor=SensorConfig(**sensor), engine="mujoco")
    return SimpleNamespace(scenario=scenario, fingers=[SimpleNamespace(name=f.name, finger=f) for f in FINGERS])


def test_force_error_is_that_of_the_end_over_all_fingers():
    time = np.arange(0.0, 3.0, 0.01)
    errors = {"left_finger": 0.2, "right_finger": -0.4}
    signals = {"time": time}
    for name, error in errors.items():
        signals[f"{name}.true_transverse_force"] = np.where(
            np.arange(len(time)) % 10, np.nan, 1.0
        )  # at every tenth sample
        signals[f"{name}.transverse_force"] = np.where(time > 2.0, 1.0 + error, 9.0)
    recording = FakeRecording({name: SimpleNamespace(values=values) for name, values in signals.items()})
    assert force_error_n(station(), recording) == pytest.approx(0.3)


def test_an_estimator_without_forces_is_refused():
    with refused("estimator.type", "arcs"):
        force_error_n(station(), FakeRecording(time=SimpleNamespace(values=np.arange(3.0))))


@pytest.mark.parametrize(
    ("sensor", "count"),
    [({"sections": 4}, 16), ({"sections": 2, "one_sided": True}, 4), ({"sections": 3, "type": "curvature"}, 6)],
)
def test_sensors_of_all_fingers_are_counted(sensor, count):
    assert sensors(station(**sensor), FakeRecording()) == count


def test_strength_is_the_least_of_six_forces_in_drake(monkeypatch):
    strengths, loaded = [3.0, 2.5, 0.9, 1.1, 4.0, 5.0], []
    monkeypatch.setattr(measures, "dump_scenario", lambda scenario: loaded.append(scenario.engine))
    monkeypatch.setattr(measures, "objects_of", lambda station: ["bottle"])
    monkeypatch.setattr(
        measures, "strength_in", lambda text, held, number, shake: SimpleNamespace(strength=strengths[number])
    )
    assert strength_n(station(), FakeRecording()) == 0.9
    assert loaded == [DRAKE]
