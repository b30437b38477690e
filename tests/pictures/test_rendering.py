"""Pictures of scenes: what is in them lies where Drake and the camera say, in the colour that it has."""

from typing import Any

import numpy as np
import pytest
from scenes import Scene

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.torque_colors import color
from soft_gripper.pictures.phases import CloseUp
from soft_gripper.pictures.rendering import MARGIN, Picture, SceneRenderer, framing_camera

BOX, IRREGULAR, SKIN = (0.25, 0.47, 0.70), (0.45, 0.62, 0.36), (0.93, 0.55, 0.36)  # as the model files say


@pytest.fixture
def box_grasp() -> Scene:
    return Scene("box_grasp")


def pixel(renderer: SceneRenderer, picture: Picture, p_W: Array) -> Array:
    """What the picture shows at a point of the world, (3,) red, green, blue from 0 to 1."""
    right, down = np.rint(renderer.camera.project(p_W)).astype(int)
    return picture[down, right] / 255


def shows(seen: Array, diffuse: Any) -> bool:
    """Whether a pixel has the colour of a surface, however brightly that is lit."""
    cosine = seen @ np.array(diffuse) / np.linalg.norm(seen) / np.linalg.norm(diffuse)
    return bool(cosine > 0.995)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.012, 0.0, 0.05), (-0.012, -0.01, 0.02)], ids=str)
def test_the_box_is_seen_where_it_is(box_grasp: Scene, shift: tuple[float, ...]) -> None:
    box_grasp.move("box", np.array(shift))
    renderer = box_grasp.renderer(box_grasp.state())
    picture = renderer.render(0.0)
    for x, z in [(0, 0), (-0.018, -0.026), (0.018, -0.026), (-0.018, 0.026), (0.018, 0.026)]:
        assert shows(pixel(renderer, picture, box_grasp.point("box", (x, -0.02, z))), BOX)
    for x, z in [(-0.037, 0.0), (0.027, 0.0), (0.0, 0.045)]:  # past the sides that are seen at an angle
        assert not shows(pixel(renderer, picture, box_grasp.point("box", (x, -0.02, z))), BOX)
    np.testing.assert_array_equal(picture[0, 0], 255)


def test_links_have_the_colour_of_the_torque_where_they_begin(box_grasp: Scene) -> None:
    torques = np.repeat([-0.1, 0.06], 6)
    renderer = box_grasp.renderer(box_grasp.state(), torques=torques, limit=0.1)
    picture = renderer.render(0.0)
    for link in range(1, 13):
        front = box_grasp.point(f"right_finger_link_{link}", (-0.009, -0.0099, 0.002))
        assert shows(pixel(renderer, picture, front), color(torques[link - 1], 0.1)), link


@pytest.mark.slow
@pytest.mark.parametrize("level", [False, True])
def test_a_close_up_goes_with_the_gripper(level: bool) -> None:
    scene = Scene("pick_and_place_box")
    states, palms, tips = [], [], []
    for posture in ([0.0, -1.57, 1.57, -1.57, -1.57, 0.0], [0.7, -1.2, 1.6, -2.0, -1.57, 1.0]):
        scene.pose_arm(posture)
        states.append(scene.state())
        palms.append(scene.point("palm", (0.0, 0.0, 0.03)))
        tips.append([scene.point(f"{finger}_link_12", (0, 0, 0.005)) for finger in scene.fingers])
    close_up = CloseUp(scene.renderer(*states), [0.0, 1.0], 120, 90, level)
    first, second = (close_up.camera(time) for time in (0.0, 1.0))
    for camera, gripper in zip((first, second), tips, strict=True):
        inside = camera.project(np.array(gripper)) / [camera.width, camera.height]
        assert np.all((inside > 0) & (inside < 1))
    shift = palms[1] - palms[0]
    assert abs(shift[2]) > 0.05
    moved = second.X_WC.translation() - first.X_WC.translation()
    np.testing.assert_allclose(moved, shift * [1, 1, 0 if level else 1], atol=1e-12)
    if not level:
        np.testing.assert_allclose(first.project(palms[0]), second.project(palms[1]), atol=1e-6)


@pytest.mark.parametrize("width", [60, 160, None])
def test_the_camera_sees_all_and_comes_as_near_as_it_can(width: int | None) -> None:
    points = np.random.default_rng(0).uniform([-0.2, -0.05, 0.0], [0.3, 0.05, 0.25], (200, 3))
    camera = framing_camera(points, 100, width)
    half = np.array([camera.width, camera.height]) / 2
    from_middle = (camera.project(points) + 0.5 - half) / half
    edges = np.array([from_middle.min(axis=0), from_middle.max(axis=0)])
    assert np.all(np.abs(edges) <= 1 - MARGIN + 1e-9)
    touches_both_sides = np.all(np.abs(edges) > 1 - MARGIN - 1e-9, axis=0)
    assert touches_both_sides.any()
    np.testing.assert_allclose(edges.sum(axis=0)[touches_both_sides], 0, atol=1e-9)
