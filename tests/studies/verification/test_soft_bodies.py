"""Soft bodies between plates: a block against F = E A strain, a ball against a series solution, and printed tables."""

import re
from pathlib import Path

import numpy as np
import pytest
from printed_numbers import table_problems

from soft_gripper.extras.soft.objects.make_soft import block
from studies.verification.soft_bodies import (
    BALLS,
    BLOCK_FORCE,
    BLOCK_SIZE,
    BLOCKS,
    FOAM,
    Material,
    PressedBall,
    ball,
    ball_rows,
    block_rows,
    hertz,
    pressed,
    shortening,
)
from studies.verification.tables import Row

PAGE = (Path(__file__).parents[3] / "studies/verification/README.md").read_text(encoding="utf-8")
MATERIAL = Material()


def test_the_series_has_the_approach_of_hertz_for_small_contacts():
    """The difference vanishes about as the radius of the contact, which is 2.15 times as large."""
    forces = [0.3, 0.03]
    ratios = [PressedBall(force, MATERIAL).change().poles / hertz(force, MATERIAL) for force in forces]
    differences = 1 - np.array(ratios)
    assert 0 < differences[1] < 0.03
    assert differences[1] < differences[0] / 2


def test_the_series_is_linear_far_from_the_contact():
    """By Saint-Venant, the force alone counts there, not the size of the contact."""
    small, large = (PressedBall(force, MATERIAL).change() for force in (0.001, 0.1))
    assert large.halves / small.halves == pytest.approx(100, rel=0.01)
    assert large.equator / small.equator == pytest.approx(100, rel=0.01)


def test_a_ball_of_tetrahedra_has_the_volume_of_a_ball():
    assert ball(4).volumes.sum() == pytest.approx(4 / 3 * np.pi * 0.022**3)
    assert ball(4).volumes.min() > 0


@pytest.mark.slow
def test_a_block_between_smooth_plates_shortens_by_the_closed_form():
    found = pressed(block(BLOCK_SIZE, (2, 2, 2)), FOAM[1], BLOCK_FORCE)
    width, depth, height = BLOCK_SIZE
    assert shortening(found) == pytest.approx(BLOCK_FORCE * height / (FOAM[1].modulus * width * depth), rel=1e-3)
    assert found.forces == pytest.approx((BLOCK_FORCE, -BLOCK_FORCE), rel=1e-4)


@pytest.fixture(scope="module")
def balls() -> list[Row]:
    """The rows of the coarser meshes; the finest takes as long as all tests here."""
    return list(ball_rows((2, 4, 6)))


@pytest.mark.slow
def test_a_ball_between_plates_is_right_far_from_the_contacts_and_better_at_them_with_a_finer_mesh(balls):
    _, *fine = np.abs([errors for _, errors in balls])
    halves, equator, poles, _ = np.transpose(fine)
    assert halves.max() < 5
    assert equator.max() < 5
    assert poles[1] < poles[0] / 2


@pytest.mark.slow
def test_the_page_prints_what_the_command_does(balls):
    shorter = re.sub(r"\| 3072 \|.*\n", "", PAGE)
    for table, rows, page in ((BLOCKS, block_rows(), PAGE), (BALLS, balls, shorter)):
        found = [[*map(float, re.findall(r"-?\d+(?:\.\d+)?", text)), *numbers] for text, numbers in rows]
        assert not table_problems(page, table.header, found)
