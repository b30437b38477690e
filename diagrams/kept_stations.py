"""kept_station: the station of an equal scenario, built once and run again with a fresh context.

To build a station takes a third of a second, and Drake before 1.58 never frees one. A station holds no state of a run,
so an equal scenario can have it again if nothing that it was built of has changed in between.
"""

from collections import OrderedDict
from copy import deepcopy
from dataclasses import replace
from hashlib import sha256

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.mesh_object import MESH_SUFFIXES
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario import Scenario, default_simulator_config
from soft_gripper.scenario.scenario_file import dump_scenario

MOST = 4  # stations that are kept, 8 to 20 MB each
_NAMES_OTHERS = (
    b"<mesh",
    b"<uri",
    b"<include",
    b"filename",
    b"file:",
)  # in the text of a model that consists of several files
_kept: OrderedDict[tuple[str, ...], Station] = OrderedDict()


def kept_station(scenario: Scenario) -> Station:
    """A station without a Meshcat; a kept one if the scenario differs in nothing but its seed and its solver.

    One with blocks of the user's is not kept, since they may remember a run; nor is one whose models consist of several
    files of the user's, any of which may have changed.

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    scenario = checked_scenario("scenario", scenario)
    key = _built_of(scenario)
    if key is None:
        return make_station(scenario)
    station = _kept.pop(key, None) or make_station(deepcopy(scenario))  # the caller may change the scenario later
    _kept[key] = station
    while len(_kept) > MOST:
        _kept.popitem(last=False)
    return replace(station, parts=replace(station.parts, scenario=scenario))


def _built_of(scenario: Scenario) -> tuple[str, ...] | None:
    """The scenario and the contents of its files; None if these cannot be known."""
    types = (scenario.sensor.type, scenario.estimator.type, *scenario.estimator.beside)
    named = [*(model.file for model in scenario.models), scenario.believed.file, scenario.believed.calibration]
    contents = [_content(file) for file in named if file is not None]
    if any(":" in name for name in types) or None in contents:
        return None
    of_a_run = replace(scenario.sensor, seed=0)
    built = replace(scenario, sensor=of_a_run, simulator_config=default_simulator_config())
    return dump_scenario(built), *filter(None, contents)


def _content(file: str) -> str | None:
    """What stands for the content of a file; None if it is missing, or consists of several."""
    path = model_path(file)
    if path.is_relative_to(DIRECTORY):
        return str([(each.name, each.stat().st_mtime_ns) for each in sorted(DIRECTORY.rglob("*"))])
    if not path.is_file() or path.suffix.lower() == ".gltf":
        return None
    content = path.read_bytes()
    is_mesh = path.suffix.lower() in MESH_SUFFIXES
    return None if not is_mesh and any(mark in content for mark in _NAMES_OTHERS) else sha256(content).hexdigest()
