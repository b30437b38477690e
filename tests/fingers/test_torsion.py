"""Saint-Venant torsion by finite elements against series and symmetries that are exact."""

import numpy as np
import pytest

from soft_gripper.fingers.cross_section import Rectangle, torsional_stiffness

MODULUS, SIDE = 89e3, 0.02  # Pa, m


def series(width, thickness):
    """J of a rectangle, m^4 (Timoshenko and Goodier, Theory of Elasticity, section 109)."""
    b, a = sorted((width, thickness))
    n = np.arange(1, 200, 2)
    return a * b**3 * (1 / 3 - 64 / np.pi**5 * b / a * np.sum(np.tanh(n * np.pi * a / (2 * b)) / n**5))


def block(width=SIDE, thickness=SIDE, modulus=MODULUS, center=0.0):
    return Rectangle(modulus, width, thickness, center)


def chamber(width=9e-3, thickness=10e-3):
    return Rectangle(0.0, width, thickness, -1e-3)


def layer(modulus, thickness=2e-4):
    return Rectangle(modulus, SIDE, thickness, (SIDE - thickness) / 2)


@pytest.mark.parametrize(("width", "thickness"), [(0.02, 0.02), (0.03, 0.01), (0.01, 0.03), (0.1, 0.002), (0.002, 0.1)])
def test_a_rectangle(width, thickness):
    found = torsional_stiffness((block(width, thickness),))
    assert found == pytest.approx(MODULUS * series(width, thickness), rel=1e-3)
    assert found >= MODULUS * series(width, thickness)  # no warping but the right one costs as little


def test_a_thin_walled_tube():
    """Bredt: 4 A^2 G / integral of ds / t, plus that of the open walls, which corners let off by some per cent."""
    wall, middle = 2e-4, SIDE - 2e-4
    tube = torsional_stiffness((block(), Rectangle(0.0, SIDE - 2 * wall, SIDE - 2 * wall, 0.0)))
    assert tube == pytest.approx(MODULUS * 4 * middle**4 / (4 * middle / wall), rel=0.01)


def test_a_layer_that_does_not_shear_mirrors_the_section():
    """It holds the warping at its face as symmetry would in a section twice as thick, twisted about that face."""
    half = MODULUS * series(SIDE, 2 * SIDE) / 2
    assert torsional_stiffness((block(), layer(1e6 * MODULUS, 2e-5))) == pytest.approx(half, rel=3e-3)


@pytest.mark.parametrize(
    ("of_layer", "expected"), [(None, 1.84e-3), (333e6, 2.82e-3), (10e6, 2.61e-3), (1e6, 2.10e-3), (89e3, 1.84e-3)]
)
def test_the_shipped_section_as_another_program_finds_it(of_layer, expected):
    """Finite elements written apart from these, converged to 0.1 %; the last digits are rounded."""
    layers = () if of_layer is None else (layer(of_layer),)
    assert torsional_stiffness((block(), chamber(), *layers)) == pytest.approx(expected, abs=0.006e-3)
