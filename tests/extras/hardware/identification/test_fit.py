"""Fits to simulated recordings find what these were simulated with."""

from dataclasses import replace

import numpy as np
import pytest
from identified import LET_GO, RELEASE, recorded, release
from refusals import refused

from soft_gripper.extras.hardware.identification.fit import fit, marker_residuals
from soft_gripper.extras.hardware.identification.free_parameters import Model, free_parameters
from soft_gripper.fingers.finger_parts import CreepBranch


@pytest.fixture(scope="module")
def motion(beam):
    return recorded(beam, release(1.2))


def softened(finger, ratio, **changes):
    """With another modulus, and other changes."""
    ends = {end: getattr(finger, end) for end in ("base", "tip")}
    moduli = {end: replace(part, youngs_modulus=ratio * part.youngs_modulus) for end, part in ends.items()}
    return replace(finger, **moduli, **changes)


@pytest.mark.slow
def test_known_parameters_are_found(beam, motion, pool):
    guess = softened(beam, 1.15, relaxation_time=0.013, creep=(CreepBranch(0.2, 0.26),))
    guess = replace(guess, tip=replace(guess.tip, youngs_modulus=beam.tip.youngs_modulus))
    names, reports = ["youngs_modulus", "youngs_modulus_ratio", "relaxation_time", "creep.time"], []
    free = free_parameters(guess, names, [])
    late = motion.with_unknowns(np.array([RELEASE, LET_GO]) + 0.02)
    found = fit(free, [late], pool.map, reports.append)
    modulus, ratio, damping, creep = free.values(found.x)
    assert modulus == pytest.approx(beam.base.youngs_modulus, rel=0.01)
    assert ratio == pytest.approx(1, rel=0.01), "of the moduli at tip and base"
    assert damping == pytest.approx(0.01, rel=0.1)
    assert creep == pytest.approx(0.2, rel=0.1)
    assert found.recordings[0].events == pytest.approx((RELEASE, LET_GO), abs=3e-3)
    assert found.model.finger.base.youngs_modulus == pytest.approx(modulus)
    assert found.error < 3e-3
    assert reports[-1].error < reports[0].error / 10
    assert reports[-1].model == found.model
    assert [each.step for each in reports] == list(range(1, len(reports) + 1))


@pytest.mark.slow
def test_jacobian_is_that_of_the_residuals(beam, motion, pool):
    """Without the part that other times of the events would bring about."""
    free = free_parameters(beam, ["youngs_modulus", "relaxation_time"], [])
    found = fit(free, [motion], pool.map)
    step, (fitted,) = 2e-4, found.recordings

    def change(model, later):
        moved = marker_residuals(model, fitted.with_unknowns(np.array(fitted.events) + later))
        return (moved - marker_residuals(found.model, fitted)) / step

    by_events = np.stack([change(found.model, later) for later in step * np.eye(2)], axis=1)
    for i in range(2):
        by_parameter = change(free.build_model(found.x + step * np.eye(2)[i]), np.zeros(2))
        expected = by_parameter - by_events @ np.linalg.lstsq(by_events, by_parameter, rcond=None)[0]
        assert found.slopes[:, i] == pytest.approx(expected, abs=0.05 * np.abs(expected).max())


def test_residuals_are_parts_of_the_largest_displacement(beam, motion):
    beside = replace(motion, markers=motion.markers + 0.1 * motion.largest)
    off = marker_residuals(Model(beam), replace(motion, markers=motion.markers)) @ np.ones(2 * motion.markers.size)
    assert abs(off) < 1e-3 * motion.markers.size
    away = marker_residuals(Model(beam), beside)
    assert np.sum(away**2) == pytest.approx((0.1 * motion.largest / beside.largest) ** 2, rel=0.05)


def test_search_leaves_what_cannot_be(beam, motion, pool):
    """Shares of creep of which nothing would be left are far off, not an error."""
    creep = (CreepBranch(0.2, 0.2), CreepBranch(0.2, 0.3))
    free = free_parameters(replace(beam, creep=creep), ["creep.share"], [])
    with refused("residual"):
        fit(free, [motion], pool.map, starts=np.log([0.55, 0.55]))
    near = fit(free, [motion], pool.map, starts=np.log([[0.55, 0.55], [0.2, 0.2]]))
    assert near.error < 0.1
