"""Parts of a finger: laws, loads, materials, and their text."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RollPitchYaw
from scipy.optimize import brentq

from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_element import SILICONES
from soft_gripper.fingers.finger_parts import CreepBranch, ElasticLaw, LinkInertias, PressureLaw, TipLoad
from soft_gripper.fingers.urdf import changed_urdf, expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.finger_changes import mounted_finger

WRONG_PARTS = [
    ({"creep": (CreepBranch(0.0, 1.0),)}, "creep[0].share = 0.0"),
    ({"creep": (CreepBranch(0.2, 1.0), CreepBranch(0.1, -1.0))}, "creep[1].time = -1.0"),
    ({"creep": (CreepBranch(0.5, 1.0),) * 2}, "creep.share = [0.5, 0.5]"),
    ({"pressure_law": PressureLaw((0.0,), (0.0,))}, "pressure_law.pressure = (0.0,)"),
    ({"pressure_law": PressureLaw((0.0, 1e5), (0.0,))}, "pressure_law.effective = (0.0,)"),
    ({"pressure_law": PressureLaw((0.0, 1e5), (0.0, -1.0))}, "pressure_law.effective = (0.0, -1.0)"),
    ({"pressure_law": PressureLaw((0.0, 1e5), (1.0, 2.0))}, "pressure_law.effective = (1.0, 2.0)"),
    ({"tip_load": TipLoad(0.0, 0.0, 0.0)}, "tip_load.mass = 0.0"),
    ({"tip_load": TipLoad(0.1, float("nan"), 0.0)}, "tip_load.x = nan"),
]


@pytest.mark.parametrize(("parts", "message"), WRONG_PARTS, ids=str)
def test_wrong_parts_are_named(shipped_finger, parts, message):
    with pytest.raises(InputError) as caught:
        replace(shipped_finger, **parts)
    assert str(caught.value).startswith(f"finger 'finger': {message}")


def test_torque_of_a_pressure_goes_by_its_law(tapered_finger):
    """Twice the torque up to 100 kPa, three times what is beyond, and straight on below zero."""
    law = PressureLaw((0.0, 1e5, 2e5), (0.0, 2e5, 5e5))
    pressures = np.array([[-1e4, 0.0, 5e4], [1e5, 1.5e5, 4e5]])
    effective = np.array([[-2e4, 0.0, 1e5], [2e5, 3.5e5, 11e5]])
    for finger, expected in ((tapered_finger, pressures), (replace(tapered_finger, pressure_law=law), effective)):
        torque = finger.pressure_torque(pressures)
        np.testing.assert_allclose(torque, expected[..., None] * finger.pressure_gain, atol=1e-12)
        np.testing.assert_allclose(finger.pressure_torque(5e4), torque[0, 2], rtol=1e-12)


def test_a_finger_bends_as_many_times_as_far_as_its_law_says(tapered_finger):
    law = PressureLaw((-1e5, 0.0, 1e5, 2e5), (-3e5, 0.0, 2e5, 5e5))
    pressures = np.array([[-1e5, -1.0, 0.0], [1e-9, 1e5, 2e5]])
    softening = replace(tapered_finger, pressure_law=law).softening(pressures)
    np.testing.assert_allclose(softening, [[3.0, 3.0, 2.0], [2.0, 2.0, 2.5]], rtol=1e-9)
    np.testing.assert_array_equal(tapered_finger.softening(pressures), np.ones((2, 3)))


def test_a_point_mass_adds_its_moments_to_those_of_the_last_link():
    """Mass, first and second moments about where the link begins are sums (parallel axes)."""
    bare = LinkInertias(
        np.array([0.03, 0.02]),
        np.array([[0.001, -0.002], [0.01, 0.012]]),
        np.array([[2e-5, 3e-5], [1e-5, 2e-5], [4e-5, 5e-5]]),
        np.array([0.0, 4e-6]),
    )
    mass, place = 0.05, np.array([0.004, 0.03])
    loaded = bare.with_load(mass, place)

    def moments(links, i):
        m, (x, z), own = links.mass[i], links.center[:, i], links.gyration[:, i]
        return np.array(
            [m, m * z, m * x, m * (own[0] + x**2), m * own[1], m * (own[2] + z**2), m * (links.product[i] + x * z)]
        )

    x, z = place
    added = mass * np.array([1, z, x, x**2, 0, z**2, x * z])
    np.testing.assert_allclose(moments(loaded, 1), moments(bare, 1) + added)
    np.testing.assert_allclose(moments(loaded, 0), moments(bare, 0))


def test_without_pressure_the_softening_is_the_slope_at_the_beginning():
    """However near the next point of the law is."""
    law = PressureLaw((0.0, 10.0, 1e5), (0.0, 30.0, 1e5))
    assert float(law.softening(0.0)) == pytest.approx(3.0)


FILES = sorted([*(DIRECTORY / "grippers").glob("*.urdf"), *(DIRECTORY / "recordings").glob("*.urdf")])
TWO_FINGER = DIRECTORY / "grippers/two_finger.urdf"


def written(tmp_path, file, **options):
    path = tmp_path / "written.urdf"
    path.write_text(changed_urdf(file, **options))
    return path


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_shipped_finger_is_read_as_it_was_written(tmp_path, file):
    again, before = expand_urdf(written(tmp_path, file)), expand_urdf(file)
    assert again.fingers == before.fingers
    assert again.text == before.text


def test_parts_that_no_shipped_gripper_has(tmp_path):
    law = ElasticLaw((-3.0, 0.0, 3.0), (-0.1, 0.0, 0.1), (-0.05, 0.0, 0.06))
    parts = {"elastic_law": law, "tip_load": TipLoad(0.01, 1e-3, 2e-3), "creep": (CreepBranch(0.1, 0.3),)}
    changed = written(tmp_path, TWO_FINGER, change=lambda m: replace(m, finger=replace(m.finger, **parts)))
    for finger in expand_urdf(changed).fingers:
        assert finger.tip_load == parts["tip_load"]
        assert finger.creep == parts["creep"]
        np.testing.assert_allclose(finger.elastic_law.curvature, law.curvature, rtol=1e-14)


def test_a_tilt_turns_the_tips_toward_the_object(tmp_path):
    seen = []

    def tilted(mounted):
        seen.append(mounted_finger(mounted, "here", {"all": {"tilt": "0.1"}}))
        return seen[-1]

    expand_urdf(TWO_FINGER, change=tilted)
    directions = [RollPitchYaw(mounted.rpy).ToRotationMatrix().matrix()[:, 2].copy() for mounted in seen]
    for mounted, z in zip(seen, directions, strict=True):
        assert z[0] * mounted.xyz[0] < 0  # toward the middle
        np.testing.assert_allclose(z[2], np.cos(0.1), rtol=1e-12)
        np.testing.assert_allclose(abs(z[0]), np.sin(0.1), rtol=1e-12)


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
