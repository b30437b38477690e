"""The recursive filter in space: that of the plane, dense conditioning, and Drake's contacts with realistic sensors."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.spatial_chain import Loads, resting_positions, spatial_chain, weights
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.path_sensors import PathSensors, SensorPath

WAYS = ("bending", "sideways", "twist")
GRAVITY = np.array([0.0, 0.0, 9.81])  # a finger that hangs points its +z down
NOISE = 2e-3
UNCERTAIN = Uncertainty(reading=NOISE, bend_per_pressure=0.05, pressure=500.0, gain=0.01, offset=1e-3, drift=3e-4)


@pytest.fixture
def spatial(shipped_finger):
    return replace(shipped_finger, yields=WAYS)


def sensors(finger, name="four_faces_and_diagonal"):
    return sensor_layout(finger, SensorConfig(layout=name, sections=2))


def swinging(count):
    """Pressures of a motion from straight to far bent and back, (count,) Pa."""
    return 60e3 * (1 - np.cos(2 * np.pi * np.arange(count) / 200))


def test_a_finger_that_stays_in_its_plane_is_estimated_as_one_that_only_bends(shipped_finger, spatial):
    """Equal while it is free, and nearly under a load, which might as well leave the plane."""
    paths = (SensorPath("outer", (-8.5e-3,), (0.0,)), SensorPath("inner", (8e-3,), (0.0,)))
    pressure = swinging(160)
    shapes = [RecursiveShape(PathSensors(each, 2, paths=paths), UNCERTAIN) for each in (shipped_finger, spatial)]
    q, driving = resting_angles(shipped_finger, pressure, 9.81 + 0j), shipped_finger.pressure_torque(pressure)
    q[120:] -= 0.02 * np.linspace(1, 0, 12) * np.minimum(1, np.arange(40) / 10)[:, None]
    noise = NOISE * np.random.default_rng(1).standard_normal((160, 4))
    readings, known = shapes[0].layout.read(1.03 * q) + noise, [shape.begin() for shape in shapes]
    torques = driving, np.concatenate([driving, np.zeros((160, 24))], axis=-1)
    for i in range(160):
        known = [shape.step(k, readings[i], u[i], GRAVITY) for shape, k, u in zip(shapes, known, torques, strict=True)]
        plane, space = known
        if i == 119:
            assert not plane.loaded
            assert not space.loaded
            np.testing.assert_allclose(space.q[:12], plane.q, atol=1e-8)
            np.testing.assert_allclose(space.mean[10:], plane.mean[5:], atol=1e-6 * UNCERTAIN.pressure)
    assert plane.loaded
    assert space.loaded
    np.testing.assert_allclose(space.q[:12], plane.q, atol=0.01 * np.abs(plane.q).max())
    planar, found = (shape.estimate(k, u[-1]).contact for shape, k, u in zip(shapes, known, torques, strict=True))
    assert found.force == pytest.approx(planar.force, rel=0.1)
    assert found.arc_length == pytest.approx(planar.arc_length, abs=5e-3)


def test_a_load_is_estimated_as_by_dense_conditioning_of_all_states(spatial):
    """By differences of the readings: a later sample of a load, about the finger under that of the sample before."""
    layout, driving = sensors(spatial), np.append(spatial.pressure_torque(60e3), np.zeros(24))
    shape, R = RecursiveShape(layout, UNCERTAIN), layout.readings
    mechanics, true = shape.mechanics, pushed(spatial, 60e3, (0, 0.4, 0))
    known = shape.begin()
    for _ in range(8):
        known = shape.step(known, layout.read(true), driving, GRAVITY)
    assert known.loaded
    found = shape.step(known, layout.read(true), driving, GRAVITY)
    at = mechanics.bent_finger(known.q)
    weight, modes = mechanics.weight(at, GRAVITY), mechanics.load_modes(at)

    def readings(state):
        z, (share, pressure), gains, offsets = np.split(state[:32], [10, 12, 12 + R])
        torque = driving * (1 + share) + pressure * mechanics.pressure_gain + weight + modes @ z
        return (1 + gains) * layout.predict(mechanics.positions_under(torque)) + offsets

    steps = np.concatenate([np.full(10, 1e-5), [1e-4, 1.0], np.full(3 * R, 1e-4)])
    later = np.eye(42)
    later[22:32, 32:] = shape.period * np.eye(R)  # offsets drift at their rates
    mean = later @ known.mean
    H = np.array([(readings(mean + step) - readings(mean - step)) for step in np.diag(steps)]).T / (2 * steps)
    before = later @ (known.covariance + np.diag(shape._walk_variances)) @ later.T
    spread = H @ before @ H.T + NOISE**2 * np.eye(R)
    left = layout.measured(layout.read(true)) - readings(mean)
    assert left @ np.linalg.solve(spread, left) < 1, "no jump"
    gain = before @ H.T @ np.linalg.inv(spread)
    gain[10:] = 0  # what is slow is kept
    expected = mean + gain @ left
    np.testing.assert_allclose(found.mean, expected, atol=1e-6 * np.abs(expected).max())
    keep = np.eye(len(steps)) - gain @ H
    covariance = keep @ before @ keep.T + NOISE**2 * gain @ gain.T
    np.testing.assert_allclose(found.covariance[:10, :10], covariance[:10, :10], atol=1e-5 * covariance[:10, :10].max())


def pushed(finger, pressures, forces):
    """Joint positions way after way, (..., 36), of a hanging finger under forces at its tip, (..., 3) N."""
    chain = spatial_chain(finger)
    own, forces = weights(finger, chain, GRAVITY), np.asarray(forces, dtype=float)
    own_forces = np.broadcast_to(own.forces, (*forces.shape[:-1], *own.forces.shape))
    all_forces = np.concatenate([own_forces, forces[..., None, :]], axis=-2)
    points = np.concatenate([own.points, [[0, 0, finger.segment_length / 2]]])
    loads = Loads(np.append(own.frames, len(chain.deformations)), points, all_forces, np.zeros_like(all_forces))
    driving = chain.interleaved({"bending": finger.pressure_torque(np.asarray(pressures))})
    q = resting_positions(chain, chain.interleaved(finger.stiffnesses), driving, loads)
    return q[..., np.argsort(chain.position_indices(WAYS))]


@pytest.mark.parametrize("lost", ["outer", "left", "rising"])
def test_nothing_is_learnt_while_the_bend_of_a_section_is_hardly_read_in_either_plane(spatial, lost):
    layout = sensors(spatial)
    shape, read = RecursiveShape(layout, UNCERTAIN), np.ones(layout.readings, dtype=bool)
    read[2 * layout.path_names.index(lost)] = False
    assert not shape._is_blind(np.ones(layout.readings, dtype=bool))
    assert shape._is_blind(read) == (lost == "outer"), "the other side and the diagonal read as much"
    read[2 * layout.path_names.index("right")] = False
    assert shape._is_blind(read) == (lost != "rising")


def test_a_filter_is_blind_without_the_readings_of_any_one_section(spatial):
    """Without those of both sides it does not see whether a section leaves its plane; one side is enough."""
    layout = sensor_layout(spatial, SensorConfig(layout="four_faces", sections=4))
    shape, faces = RecursiveShape(layout, UNCERTAIN), np.arange(16).reshape(4, 4)

    def is_blind(*lost):
        return bool(shape._is_blind(~np.isin(np.arange(16), lost)))

    assert not is_blind()
    sides = [layout.path_names.index(name) for name in ("left", "right")]
    for section in range(4):
        assert is_blind(*faces[:, section])
        assert is_blind(*faces[sides, section])
        assert not is_blind(faces[sides[0], section])
