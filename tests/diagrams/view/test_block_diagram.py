"""Block diagrams as text and as pictures."""

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.view.block_diagram import graphviz, save_block_diagram
from soft_gripper.scenario.scenario_file import load_scenario

BEGINNINGS = {"dot": b"digraph", "gv": b"digraph", "svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}


@pytest.fixture(scope="module")
def diagram():
    return make_station(load_scenario("free_bending")).diagram


def test_text_shows_the_blocks_as_deep_as_asked(diagram):
    top, inside = graphviz(diagram, max_depth=1), graphviz(diagram, max_depth=2)
    for block in ("plant", "left_finger.sensors", "left_finger.estimation", "right_finger.pressure_drive", "logs"):
        assert block in top
    for inner in ("force_estimator", "true_external_torque", "sampled_pressure"):
        assert f"name={inner}\n" not in top
        assert f"name={inner}\n" in inside


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "beginning"), BEGINNINGS.items())
def test_file_is_of_the_kind_that_its_name_says(tmp_path, diagram, suffix, beginning):
    path = tmp_path / f"station.{suffix}"
    save_block_diagram(diagram, path)
    assert path.read_bytes().startswith(beginning)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["station.jpg", "station", "station.SVG.txt"])
def test_other_endings_are_refused(tmp_path, diagram, name):
    with refused("FILE"):
        save_block_diagram(diagram, tmp_path / name)
    assert not list(tmp_path.iterdir())
