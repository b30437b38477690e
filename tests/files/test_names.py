"""Names become parts of signals, files and axes."""

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.models import DIRECTORY
from soft_gripper.quantity import is_name
from soft_gripper.scenario.scenario_file import load_scenario


@pytest.mark.parametrize("name", ["a.b", "δ", "plant", "logs", "scene_graph", "true_contact", "grip", "all"])
def test_fingers(tmp_path, name):
    """Refused when the station is built, not after the run."""
    file = tmp_path / "hand.urdf"
    file.write_text((DIRECTORY / "grippers" / "two_finger.urdf").read_text().replace("left_finger", name))
    with refused("finger.name" if is_name(name) else "name", name):
        make_station(load_scenario("box_grasp", [f"models.0.file={file}"]))
