"""docs/finger.md: its table of materials is that of the code."""

import re
from pathlib import Path

from soft_gripper.fingers.finger_element import SILICONES

TEXT = (Path(__file__).parents[1] / "docs/finger.md").read_text(encoding="utf-8")


def test_materials_are_those_of_the_code():
    rows = re.findall(r"^\| `(\w+)` \| (\d+) \| (\d+) \|", TEXT, re.MULTILINE)
    written = {name: (int(modulus), int(density)) for name, modulus, density in rows}
    assert written == {name: (round(s.youngs_modulus / 1e3), s.density) for name, s in SILICONES.items()}
