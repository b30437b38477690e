"""A station that is played."""

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.scenario.scenario_file import load_scenario


def played(name: str, grip: str | None = None, *overrides: str) -> tuple[Station, Meshcat]:
    """The station of a shipped scenario with its commands left open, and what shows it."""
    meshcat = hidden_meshcat()
    return make_station(open_scenario(load_scenario(name, overrides), grip), meshcat), meshcat
