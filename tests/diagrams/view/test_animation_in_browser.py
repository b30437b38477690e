"""An animation, opened from its file in a real browser: it draws offline, and its colours change with time."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from browser import Pixels, open_offline, screenshot
from pydrake.geometry import Meshcat

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.view.meshcat_view import write_animation
from soft_gripper.diagrams.view.torque_colors import color
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

END = 0.8  # s
CONTROLS, LEGEND = 30, -80  # rows of a screenshot above the scene, and below it
Look = Callable[[float], Pixels]


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The browser, with the animation of a gripper, one finger of which closes against a peg."""
    folder = tmp_path_factory.mktemp("animation")
    steps = {"left_finger": [0.0, 180e3], "right_finger": [0.0, -50e3]}  # the other finger keeps out of the way
    short = [f"pressure.steps={steps}", "pressure.settle=0.39", "pressure.hold_samples=1"]
    meshcat = Meshcat()
    run_station(make_station(load_scenario("obstructed_inside", short), meshcat), meshcat)
    write_animation(meshcat, folder / "animation.html")
    driver = open_offline(folder / "animation.html", folder / "profile")
    driver.set_script_timeout(60)
    # Two frames after all has come, so that textures are there too.
    driver.execute_async_script(
        """
        const done = arguments[0];
        const ready = () => typeof viewer !== "undefined" && viewer.animator.duration > 0;
        const wait = () => ready() ? setTimeout(done, 500) : setTimeout(wait, 50);
        wait();
        """
    )
    yield driver
    driver.quit()


@pytest.fixture
def look(driver: Any) -> Look:
    """The page at a time of the animation."""

    def look(time: float) -> Pixels:
        driver.execute_async_script(
            """
            viewer.animator.pause();
            viewer.animator.seek(arguments[0]);
            viewer.set_dirty();
            requestAnimationFrame(() => requestAnimationFrame(arguments[1]));
            """,
            time,
        )
        return screenshot(driver)

    return look


def count(pixels: Pixels, stronger: int, weaker: int) -> int:
    """Number of pixels in which one channel is stronger than another by far."""
    return int(np.sum(pixels[..., stronger] - pixels[..., weaker] > 60))


def scene(pixels: Pixels) -> Pixels:
    """The part of a screenshot between Meshcat's controls and the legend."""
    return pixels[CONTROLS:LEGEND]


def test_colors_change_with_time(look: Look) -> None:
    before, after = (scene(look(time)) for time in (0.0, END))
    assert count(before, stronger=2, weaker=0) == 0
    assert count(after, stronger=2, weaker=0) > 2000, "the peg holds the finger open: blue"


def test_the_legend_has_the_colors_of_the_scale_in_any_light(driver: Any, look: Look) -> None:
    lights = "viewer.scene_tree.find(['Lights']).object.visible = {}"
    for lit in ("false", "true"):
        driver.execute_script(lights.format(lit))
        legend = look(0.0)[LEGEND:].reshape(-1, 3)
        for torque in (-0.95, 0.95):
            distance = np.abs(legend - 255 * color(np.array(torque), 1.0)).max(axis=-1)
            assert np.sum(distance < 30) > 50
