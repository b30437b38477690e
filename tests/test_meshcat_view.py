"""What Meshcat holds after a run, and what a replay keeps of it."""

import base64
import gzip
import re
from pathlib import Path

import pytest
from pydrake.geometry import Meshcat

from soft_gripper.diagrams.estimate_visualizer import ARCS, CURVE
from soft_gripper.diagrams.replay import write_replay
from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station


@pytest.fixture(scope="module")
def replay(tmp_path_factory: pytest.TempPathFactory) -> tuple[Meshcat, str]:
    """A short grasp shown in Meshcat, and the page of its replay."""
    meshcat, path = Meshcat(), tmp_path_factory.mktemp("replay") / "replay.html"
    short = ["pressure.steps.all=[50e3, 100e3]", "pressure.settle=0.1", "pressure.hold_samples=1"]
    run_station(make_station(load_scenario("box_grasp", short), meshcat), meshcat)
    write_replay(meshcat, path)
    return meshcat, unpacked(path)


def unpacked(path: Path) -> str:
    (packed,) = re.findall(r"base64,([A-Za-z0-9+/=]+)", path.read_text())
    return gzip.decompress(base64.b64decode(packed)).decode()


def test_meshcat_has_bodies_estimates_and_legend(replay: tuple[Meshcat, str]) -> None:
    meshcat, _ = replay
    for finger in ("left_finger", "right_finger"):
        for path in (
            f"{CURVE}/{finger}/0",
            f"{ARCS}/{finger}/0/unit/circle",
            f"/drake/visualizer/gripper/{finger}_link_12/gripper/Box/<object>",
            f"/drake/visualizer/gripper/{finger}_link_12/gripper/Cylinder/<object>",
        ):
            assert meshcat.HasPath(path), path
    assert meshcat.HasPath("/Cameras/default/rotated/<object>/legend")


def test_all_that_is_colored_is_there_to_be_colored(replay: tuple[Meshcat, str]) -> None:
    """The paths of the links' shapes are those at which MeshcatVisualizer draws, in this version of Drake."""
    messages = messages_of(replay[1])
    objects = {path for kind, path in messages if kind == b"set_object"}
    colored = {path for kind, path in messages if kind == b"set_property" and path.endswith(b"/<object>")}
    links = {path.removesuffix(b"/<object>") for path in colored if path.startswith(b"/drake/visualizer")}
    assert len(links) == 2 * (13 + 12), "a box for every link, and a knuckle for all but the first of a finger"
    assert links <= objects


def test_the_recording_holds_colors_poses_and_arcs(replay: tuple[Meshcat, str]) -> None:
    (animation,) = (data for data in payloads_of(replay[1]) if b"set_animation" in data)
    for track in (b".material.color[r]", b".position", b".quaternion", b".scale", b".rotation[y]", b".visible"):
        assert track in animation, track


def payloads_of(page: str) -> list[bytes]:
    return [base64.b64decode(data) for data in re.findall(r"octet-binary;base64,([A-Za-z0-9+/=]+)", page)]


def messages_of(page: str) -> set[tuple[bytes, bytes]]:
    """What Meshcat's messages do (set_object ...), and to which path."""
    found = (
        re.search(rb"\xa4type.(\w+?)\xa4path(?:\xd9.|[\xa0-\xbf])(/[ -~]+)", data, re.DOTALL)
        for data in payloads_of(page)
    )
    return {(match[1], match[2]) for match in found if match}
