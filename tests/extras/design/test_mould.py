"""Moulds of a design, and the measures of its sensors and strength."""

import re
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.design import measures
from soft_gripper.extras.design.measures import force_error_n, sensors, strength_n
from soft_gripper.extras.design.mould import GROWTH, SHELL, cores, least_wall, loft, outer_rings, shell
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import DRAKE, Scenario, SensorConfig

GRIPPERS = DIRECTORY / "grippers"


def finger(name):
    return expand_urdf(GRIPPERS / f"{name}.urdf").fingers[0]


def volume(rings):
    """Of a solid through rectangles, mm^3: between two of them the area is a parabola, so Simpson's rule is exact."""
    total = 0.0
    for (low, *_, t0, w0), (high, *_, t1, w1) in pairwise(rings):
        middle = (t0 + t1) * (w0 + w1) / 4
        total += (high - low) / 6 * (t0 * w0 + 4 * middle + t1 * w1)
    return total


@pytest.mark.parametrize("name", ["two_finger", "three_finger", "conforming", "three_chambers", "two_finger_tendons"])
def test_meshes_are_closed(name):
    of = finger(name)
    for mesh in (shell(of), *cores(of)):
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.volume > 0


def test_a_core_has_the_volume_of_the_chamber():
    """Tapered in one direction: thickness 10 to 9.5 mm over 120 mm, of which the last wall, 3.8 mm, is left out."""
    (core,) = cores(finger("two_finger"))
    length = 120 - 3.8
    end = 10 - 0.5 * length / 120
    assert core.volume == pytest.approx(9 * length * (10 + end) / 2, rel=1e-9)
    np.testing.assert_allclose(core.bounds, [[-1 - 5, -4.5, 0], [-1 + 5, 4.5, length]], atol=1e-9)


def test_the_shell_is_what_is_round_the_finger():
    of = finger("two_finger")
    inside = outer_rings(of)
    outside = inside + SHELL * GROWTH
    floor = np.prod(outside[-1, 3:]) * SHELL
    assert shell(of).volume == pytest.approx(volume(outside) + floor - volume(inside), rel=1e-9)
    assert loft(inside).volume == pytest.approx(volume(inside), rel=1e-9)


def test_the_thinnest_wall():
    of = finger("two_finger")
    assert least_wall(of) == pytest.approx(min(float(w) for s in of.cross_sections for w in s.walls.values()))
    assert least_wall(of) == pytest.approx(3.8e-3)  # outer, at the tip: 9.5 - 0.95 - 4.75


def test_walls_between_chambers_that_are_given_along_the_finger():
    of = finger("three_chambers")
    holes = of.section(0.0).holes
    gaps = [
        max(abs(a.x - b.x) - (a.thickness + b.thickness) / 2, abs(a.y - b.y) - (a.width + b.width) / 2)
        for i, a in enumerate(holes)
        for b in holes[:i]
    ]
    assert 0 < least_wall(of) <= min(map(float, gaps))


def test_the_shell_is_as_thick_as_the_page_says():
    page = (Path(__file__).parents[3] / "docs" / "extras" / "design" / "design.md").read_text()
    thickness = float(re.search(r"the shell is ([0-9.]+) mm thick", page)[1])
    of = finger("two_finger")
    outline = np.array([20 + 2 * thickness, 20 + 2 * thickness, 120 + thickness])
    np.testing.assert_allclose(shell(of).extents, outline, atol=1e-9)


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
        measures, "direction_strength", lambda text, held, number, shake: SimpleNamespace(strength=strengths[number])
    )
    assert strength_n(station(), FakeRecording()) == 0.9
    assert loaded == [DRAKE]
