"""The softness of a held block, as the study finds it."""

import numpy as np
import pytest

from studies.benchmark.softness import SECTIONS, compliance, grasp_compliance, likeliest


def test_compliance_is_the_decrease_of_the_gap_over_the_increase_of_the_force():
    assert compliance(np.array([0.044, 0.043, 0.041]), np.array([0.5, 1.0, 2.0])) == pytest.approx(2e-3)


def test_the_likeliest_material_takes_its_spread_into_account():
    trained = {"narrow": np.array([0.9, 1.0, 1.1]), "wide": np.array([1.0, 2.0, 3.0])}
    assert likeliest(np.array([1.05, 1.4, 0.0]), trained) == ["narrow", "wide", "wide"]


@pytest.mark.slow
def test_a_sponge_is_more_compliant_than_wood_with_any_sensors():
    """By more than the spread of realistic sensors."""
    sponge, wood = (grasp_compliance(1, "test", 0, material) for material in ("20 kPa", "wood"))
    for sections in SECTIONS:
        assert sponge[sections].ideal > 2 * wood[sections].ideal
        assert sponge[sections].realistic.min() > wood[sections].realistic.max()
