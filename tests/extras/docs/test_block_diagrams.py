"""The pictures of block diagrams: all blocks and wires of the diagram, but those that are left out."""

from block_diagrams import draw
from example_blocks import station


def test_blocks_and_wires_are_drawn(tmp_path):
    draw(station("tip_distance_steps").diagram, tmp_path / "blocks.svg", but=("right_finger",))
    text = (tmp_path / "blocks.svg").read_text(encoding="utf-8")
    assert "<title>plant&#45;&gt;left_finger.joint_angles</title>" in text
    assert "<title>left_finger.estimation&#45;&gt;grip_control</title>" in text
    assert "GripControl" in text
    assert "right_finger" not in text
    assert "<title>logs" not in text


def test_a_part_shows_what_goes_in_and_out(tmp_path):
    draw(station("tip_distance_steps").diagram.GetSubsystemByName("left_finger.sensors"), tmp_path / "part.svg")
    text = (tmp_path / "part.svg").read_text(encoding="utf-8")
    assert "<title>in joint_angles&#45;&gt;sensor</title>" in text
    assert "<title>sensor&#45;&gt;out sensor</title>" in text
