"""The picture of a diagram: all blocks and wires, but those that are left out."""

import pytest

import soft_gripper as sg

pytest.importorskip("pygraphviz")


@pytest.fixture(scope="module")
def diagram():
    return sg.make_station(sg.load_scenario("tip_distance_steps")).diagram


def test_blocks_and_wires_are_drawn(diagram):
    text = sg.block_picture(diagram, without=("right_finger",))
    assert "<title>plant&#45;&gt;left_finger.joint_angles</title>" in text
    assert "<title>left_finger.estimation&#45;&gt;grip_control</title>" in text
    assert "GripControl" in text
    assert "right_finger" not in text
    assert "<title>logs" not in text


def test_a_part_shows_what_goes_in_and_out(diagram):
    text = sg.block_picture(diagram.GetSubsystemByName("left_finger.sensors"))
    assert "<title>in joint_angles&#45;&gt;sensor</title>" in text
    assert "<title>sensor&#45;&gt;out sensor</title>" in text
