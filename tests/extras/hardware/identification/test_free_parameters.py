"""Keys of a finger as one vector of numbers, there and back."""

from dataclasses import fields, replace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.hardware.identification.free_parameters import (
    KEYS,
    Model,
    free_parameters,
    pressure_law,
    pressure_law_keys,
)
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.fingers.cross_section import CrossSection, Station
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.paths import Tendon

PRESSURES = [1e4, 2e4, 4e4]


@pytest.fixture(scope="module")
def guessed(hollow):
    """A finger that has something of every key, and tapers."""
    return replace(
        hollow, shear_factor=0.85, creep=(CreepBranch(0.1, 0.1), CreepBranch(0.2, 2.0)), tip=stiffer(hollow.tip)
    )


def stiffer(section):
    return replace(section, youngs_modulus=2 * section.youngs_modulus)


@pytest.fixture(scope="module")
def tendoned(hollow):
    """A finger with tendons and a layer, which does not shear."""
    layer = {"layer_thickness": 1e-3, "layer_modulus": 1e6, "layer_shear_modulus": 2e5}
    slanted = Tendon("a", (4e-3, -3e-3), (1e-3, 5e-3), (0.0, 0.7), 2e3, slack=2e-4)
    tendons = slanted, Tendon("b", (0.0,), (-4e-3,), (0.0, 1.0), 1e3)
    return hollow.with_sections(lambda section: replace(section, **layer), tendons=tendons)


OF_TENDONS = [name for name in KEYS if name.startswith("tendon.") or name.startswith("layer_")]
OTHERS = [name for name in KEYS if name not in OF_TENDONS]


def test_every_key_begins_with_the_finger_as_it_is(guessed, tendoned):
    free = free_parameters(tendoned, OF_TENDONS, [])
    again = free_parameters(free.build_model(free.start).finger, OF_TENDONS, [])
    np.testing.assert_allclose(again.start, free.start, rtol=1e-12)
    free = free_parameters(guessed, OTHERS, [])
    found = free.build_model(free.start)
    again = free_parameters(found.finger, OTHERS, [])
    assert (found.setup.fill_time, found.setup.swelling) == pytest.approx((Setup().fill_time, Setup().swelling))
    np.testing.assert_allclose(again.values(again.start)[:10], free.values(free.start)[:10], rtol=1e-12)
    assert found.finger.tip.youngs_modulus == pytest.approx(guessed.tip.youngs_modulus)


def test_sections_keep_their_ratios_to_the_first_that_is_not_0(hollow):
    solid = {"chamber_width": 0.0, "chamber_thickness": 0.0, "chamber_center": 0.0}
    names = [part.name for part in fields(CrossSection)]
    built = {name: getattr(hollow.base, name) for name in names}
    first, second = Station(**built, at=0.5), stiffer(Station(**built, at=0.5))
    finger = replace(hollow, base=replace(hollow.base, **solid), sections=(replace(first, **solid), second))
    free = free_parameters(finger, ["youngs_modulus", "chamber_width"], [])
    found = free.build_model(free.start + np.log([1.2, 1.1])).finger
    assert free.values(free.start).tolist() == pytest.approx([hollow.base.youngs_modulus, hollow.base.chamber_width])
    for part, before in zip(found.cross_sections, finger.cross_sections, strict=True):
        assert part.youngs_modulus == pytest.approx(1.2 * before.youngs_modulus)
        assert part.chamber_width == pytest.approx(1.1 * before.chamber_width)
        assert part.thickness == before.thickness


@pytest.mark.parametrize(("finger", "keys"), [("guessed", OTHERS), ("tendoned", OF_TENDONS)])
def test_every_number_changes_what_it_is_called_after(finger, keys, request):
    free = free_parameters(request.getfixturevalue(finger), keys, [])
    lower, upper = free.bounds
    for i, name in enumerate(free.names):
        x = free.start
        x[i] = np.clip(x[i] + 0.1 * free.scales[i], lower[i], upper[i])
        model = free.build_model(x)
        changed = replace(free, model=model)
        differ = np.flatnonzero(~np.isclose(changed.start, free.start, rtol=1e-9, atol=1e-12))
        assert [free.names[k] for k in differ] == [name]
        assert changed.start[i] == pytest.approx(x[i])


def test_a_path_is_turned_as_a_whole(tendoned):
    free = free_parameters(tendoned, ["tendon.angle"], [])
    turned, straight = free.build_model(free.start + np.array([0.3, 0.0])).finger.tendons
    before = np.array([tendoned.tendons[0].x, tendoned.tendons[0].y])
    c, s = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose([turned.x, turned.y], np.array([[c, -s], [s, c]]) @ before, atol=1e-15)
    assert (turned.at, straight) == (tendoned.tendons[0].at, tendoned.tendons[1])


@pytest.mark.parametrize("margin", [0.15, 1.0, 3.0])
def test_pressure_law_is_read_as_it_is_written(hollow, margin):
    law, p = pressure_law(4e4, 1.3, margin), np.array([0.0, 1e3, 2e4, 4e4])
    np.testing.assert_allclose(law.bend(p), 1.3 * p / (1 - (1 - margin) * p / 4e4), rtol=1e-9)
    assert float(law.bend(-3e4)) == pytest.approx(-3.9e4)  # a vacuum takes nothing of the stiffness
    model = Model(replace(hollow, pressure_law=law))
    values = [key.get(model)[0] for key in pressure_law_keys(PRESSURES).values()]
    np.testing.assert_allclose(values, [1.3, margin], rtol=1e-9)


@pytest.mark.parametrize(
    "names",
    [["stiffness"], ["pressure_law"], ["length", "length"], ["creep.time"], ["shear_factor"], ["chamber_width"]],
)
def test_keys_that_cannot_be_fitted(beam, names):
    with refused("--free", names[0]):
        free_parameters(replace(beam, creep=()), names, [])


def test_searches_begin_with_the_finger_as_it_is_and_near_it(guessed):
    free = free_parameters(guessed, ["youngs_modulus", "creep.share"], [])
    first, *others = free.starts(9, 1, 2.0)
    np.testing.assert_array_equal(first, free.start)
    away = (np.array(others) - free.start) / free.scales
    assert 0.1 < np.abs(away).mean() / 2.0 < 2  # of standard deviations
