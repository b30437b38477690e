"""Shipped fingers that creep, as files that a scenario can name."""

import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.scenario.model_files import model_path

FINGER = "package://soft_gripper/grippers/finger.urdf"
GRIPPER = "package://soft_gripper/grippers/two_finger.urdf"


def write_creeping(shipped: str, folder: Path, share: float, time: float) -> str:
    """A shipped file whose fingers creep by a share, with a time in s; what a scenario calls it."""
    tree, file = ET.parse(model_path(shipped)), folder / Path(shipped).name
    for finger in tree.iter("finger"):
        ET.SubElement(finger, "creep", share=str(share), time=str(time))
    tree.write(file)
    return str(file)
