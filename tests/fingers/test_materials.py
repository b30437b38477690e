"""The table of silicones: plausible, sourced, and its rule for what bulletins state."""

import pytest
from scipy.optimize import brentq

from soft_gripper.fingers.finger_element import SILICONES


@pytest.mark.parametrize(("name", "psi"), [("ecoflex_00_30", 10), ("ecoflex_00_50", 12), ("dragon_skin_30", 86)])
def test_at_twice_its_length_it_bears_what_the_bulletin_states(name, psi):
    """A neo-Hookean bar of small-strain modulus E under a nominal stress, stretched by bisection."""
    modulus, stress = SILICONES[name].youngs_modulus, psi * 0.45359237 * 9.80665 / 0.0254**2
    stretch = brentq(lambda x: modulus / 3 * (x - x**-2) - stress, 1.0, 5.0)
    assert stretch == pytest.approx(2.0, rel=1e-6)


def test_the_rule_agrees_with_the_modulus_that_was_measured():
    """Dragon Skin 10: 22 psi at 100 % strain."""
    by_rule = SILICONES["ecoflex_00_30"].youngs_modulus * 22 / 10
    assert by_rule == pytest.approx(SILICONES["dragon_skin_10"].youngs_modulus, rel=0.02)
