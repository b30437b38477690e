"""Elastic laws of the user's: the block, the <elastic_law> of a file, and what the finger does with it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.statics import elastic_law_block, free_bending_angles
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY

LAW = ElasticLaw(
    curvature=(-50.0, -10.0, 5.0, 12.0, 40.0),
    base_moment=(-0.6, -0.1, 0.08, 0.1, 0.5),
    tip_moment=(-0.3, -0.1, 0.04, 0.09, 0.2),
)
STIFFENING = ([-0.3, -0.1, 0.0, 0.1, 0.3], [-0.5, -0.12, 0.0, 0.12, 0.5], [-0.44, -0.1, 0.0, 0.1, 0.44])  # rad, N m
PRESSURES = [210e3, 100e3, -50e3]
FINGERS = ("left_finger", "right_finger")


def with_law(text: str, law) -> str:
    """The text of a gripper file whose fingers get an elastic law."""
    columns = [column if isinstance(column, str) else " ".join(map(str, column)) for column in law]
    element = '<elastic_law angle="{}" base_torque="{}" tip_torque="{}"/>'.format(*columns)
    return text.replace("<sensors", element + "<sensors")


@pytest.fixture
def gripper(tmp_path):
    """Writes a shipped gripper with an elastic law beside the test."""

    def write(name: str, law) -> Path:
        (tmp_path / name).write_text(with_law((DIRECTORY / "grippers" / name).read_text(), law))
        return tmp_path / name

    return write


def at_joints(finger, base, tip):
    """What runs from base to tip, (M,) each, at every joint, (N, M)."""
    along = (np.arange(finger.segments)[:, None] + 0.5) / finger.segments
    return (1 - along) * np.array(base) + along * np.array(tip)


def straight_on(x, x_points, y_points):
    """np.interp, but with end pieces that go on."""
    slopes, far = np.diff(y_points) / np.diff(x_points), 1e3
    first, last = y_points[0] - far * slopes[0], y_points[-1] + far * slopes[-1]
    return np.interp(x, [x_points[0] - far, *x_points, x_points[-1] + far], [first, *y_points, last])


def run(file, *overrides):
    """Free bending with other fingers, and the ends of its PRESSURES, s."""
    files = [f"models.{i}.file={file}" for i in (0, 1)]
    return simulate(free_bending(PRESSURES, 1.0, *files, *overrides)), [1.0, 2.0, 3.0]


def test_block_is_what_turns_the_springs_into_the_law(tapered_finger):
    finger = replace(tapered_finger, elastic_law=LAW)
    block = elastic_law_block(finger)
    context = block.CreateDefaultContext()
    angles, laws = np.array(LAW.curvature) * 0.12 / 5, at_joints(finger, LAW.base_moment, LAW.tip_moment)
    for q in np.random.default_rng(1).uniform(-3, 3, (200, 5)):  # the points end at -1.2 and 0.96 rad
        block.GetInputPort("x").FixValue(context, q)
        law = [straight_on(angle, angles, torques) for angle, torques in zip(q, laws, strict=True)]
        torque = block.GetOutputPort("y").Eval(context)
        np.testing.assert_allclose(torque, finger.stiffness * q - law, atol=1e-12)


def test_any_number_of_segments_bends_alike(gripper):
    """A law is that of the material: chains converge to one beam with the square of the segment length."""
    file = gripper("finger.urdf", STIFFENING)
    fingers = [expand_urdf(file, segments).fingers[0] for segments in (6, 12, 24, 48)]
    coarse, middle, fine = np.abs(np.diff([free_bending_angles(f, np.array(210e3)).sum() for f in fingers]))
    assert coarse / middle == pytest.approx(4, rel=0.05)
    assert middle / fine == pytest.approx(4, rel=0.05)
    assert fine < 1e-4


@pytest.mark.slow
def test_estimators_know_the_law(gripper):
    recording, ends = run(gripper("finger.urdf", STIFFENING), "plant_config.time_step=0.005")
    for finger in FINGERS:
        estimated = recording[f"{finger}.external_torque"].sel(time=ends, method="nearest")
        assert np.abs(estimated).max() < 2e-3
