"""The block diagrams of the concepts page, drawn from stations."""

from pathlib import Path

from example_blocks import station
from pydrake.systems.framework import Diagram

import soft_gripper as sg
from soft_gripper.diagrams.view.block_diagram import save_block_diagram

_OTHER_FINGER = ("right_finger",)
_BESIDE_THE_ARM = (
    "left_finger.scoring",
    "left_finger.contact_torque",
    "true_contact",
    "object_width",
    "box",
    "arm.joint_",
)


def save_diagrams(folder: Path) -> None:
    """Writes the pictures of the concepts page, SVG, and one that has every port."""
    grasp = station("tip_distance_steps").diagram
    draw(grasp, folder / "station.svg", _OTHER_FINGER)
    for part in ("sensors", "estimation", "scoring"):
        draw(grasp.GetSubsystemByName(f"left_finger.{part}"), folder / f"{part}.svg")
    draw(grasp.GetSubsystemByName("gripper.pressure_drive"), folder / "pressure_drive.svg")
    draw(grasp.GetSubsystemByName("grip_control"), folder / "grip_control.svg")
    draw(station("pick_and_place_box").diagram, folder / "arm.svg", (*_OTHER_FINGER, *_BESIDE_THE_ARM))
    save_block_diagram(grasp, folder / "every_port.svg")


def draw(diagram: Diagram, path: Path, but: tuple[str, ...] = ()) -> None:
    """Writes the picture of a diagram without names that begin with one of `but`."""
    path.write_text(sg.block_picture(diagram, but), encoding="utf-8")
