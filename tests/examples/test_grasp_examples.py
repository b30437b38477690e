"""Examples of grasps: fingers that conform to a box, and what is known of a force."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize

from pictures.conforming_grasp import (
    CONFORMING,
    SHIPPED,
    Grasp,
    mean_pressure,
    run_grasp,
    scenarios,
)
from pictures.force_ellipses import CASES, read_press
from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.scenario_file import load_scenario

WIDTH = 0.02  # m, of the fingers


@cache
def grasps() -> dict[str, Grasp]:
    return {name: run_grasp(scenario) for name, scenario in scenarios().items()}


@pytest.mark.slow
def test_a_conforming_finger_touches_ten_times_the_area_of_the_box() -> None:
    conforming, shipped = grasps()[CONFORMING], grasps()[SHIPPED]
    assert (shipped.area[-1] > 0).sum() == 1
    assert (conforming.area[-1] > 0).sum() == 5
    assert 1e6 * conforming.area[-1].sum() == pytest.approx(587, rel=0.02)
    assert 1e6 * shipped.area[-1].sum() == pytest.approx(57, rel=0.02)
    assert mean_pressure(conforming)[-1] < mean_pressure(shipped)[-1] / 10


@pytest.mark.slow
def test_links_that_lie_on_the_box_touch_it_all_over() -> None:
    """Those between the ones at the ends of the contact, by their width and length."""
    for step in (-2, -1):
        area, lengths = grasps()[CONFORMING].area[step], np.diff(grasps()[CONFORMING].finger.link_ends)
        (touching,) = np.nonzero(area)
        inside = touching[1:-1]
        np.testing.assert_allclose(area[inside], WIDTH * lengths[inside], rtol=1e-3)
        assert (area <= WIDTH * lengths * (1 + 1e-3)).all()


def face_points(finger: Finger, q: Array, along: Array) -> Array:
    """Points on the inner faces of the links, at shares (M) of their lengths, (N + 1, M, 2) m in B, x and z."""
    heading, lengths = np.concatenate([[0.0], np.cumsum(q)]), np.diff(finger.link_ends)
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    across = np.stack([np.cos(heading), -np.sin(heading)], axis=-1)
    ends = np.cumsum(lengths[:, None] * ahead, axis=0)
    face = np.asarray(finger.section(finger.link_ends[:-1] + lengths / 2).inner_face)
    rest = lengths[:, None] * (along - 1)
    return (ends + face[:, None] * across)[:, None] + rest[..., None] * ahead[:, None]


def contact_by_statics(finger: Finger, pressure: float, box: Array) -> tuple[Array, Array]:
    """Area, m^2, and force, N, of each link on a rigid frictionless face, (N + 1) each.

    The energy of springs, pressure and skin is least. The skin presses with its modulus times the depth over half the
    smallest side of a link, of twelve as long as the finger and with half links at its ends.
    """
    gap, top = box.min(axis=0)
    lengths, (nodes, weights) = np.diff(finger.link_ends), np.polynomial.legendre.leggauss(40)
    sides = np.full(len(lengths), finger.length / 12)
    sides[[0, -1]] /= 2
    bed = finger.contact.hydroelastic_modulus / (np.minimum(sides, WIDTH) / 2)
    driven, stiffness = finger.pressure_torque(pressure), finger.stiffness
    areas = WIDTH * lengths[:, None] * weights / 2

    def depth(q: Array) -> Array:
        x, z = np.moveaxis(face_points(finger, q, (nodes + 1) / 2), -1, 0)
        return np.where(z > top, np.maximum(x - gap, 0.0), 0.0)

    def energy(q: Array) -> float:
        skin = np.sum(bed[:, None] * areas * depth(q) ** 2 / 2)
        return float(1e6 * (stiffness @ q**2 / 2 - driven @ q + skin))

    found = minimize(energy, np.zeros(finger.segments), method="BFGS", options={"gtol": 1e-4, "maxiter": 2000})
    pressed = depth(found.x)
    return (areas * (pressed > 0)).sum(axis=1), (bed[:, None] * areas * pressed).sum(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("pressure", [125e3, 175e3, 200e3])
def test_contact_is_that_of_statics_where_nothing_rubs(pressure: float) -> None:
    smooth = ["models.gripper.fingers.all.contact.friction=0", "models.box.free=false", "gravity=[0, 0, 0]"]
    steps = [f"pressure.steps.all=[{pressure}]", "pressure.settle=4"]
    grasp = run_grasp(load_scenario(CONFORMING, [*smooth, *steps]))
    area, force = contact_by_statics(grasp.finger, pressure, grasp.box)
    np.testing.assert_allclose(grasp.force[-1], force, atol=0.004 * force.sum())
    assert grasp.area[-1].sum() == pytest.approx(area.sum(), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_ellipse_is_long_along_the_line_and_holds_the_truth(name: str) -> None:
    press = read_press(name)
    line = press.point / np.linalg.norm(press.point)
    across = np.array([line[1], -line[0]])
    along, over = (np.sqrt(axis @ press.covariance @ axis) for axis in (line, across))
    assert 5 < along / over < 8
    error = press.true - press.force
    assert error @ np.linalg.solve(press.covariance, error) < 5.99  # chi-squared of two, 95 %
    assert abs(error @ across) < 0.1 * np.linalg.norm(press.true)
