"""What is recorded in the middle of a run is that part of the run."""

from pathlib import Path

import numpy as np
import pytest
from live_station import played

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import make_simulator
from soft_gripper.extras.play.station_recorder import StationRecorder
from soft_gripper.files.output import is_whole
from soft_gripper.scenario.scenario_file import load_scenario

BEGIN, END = 0.3, 0.6  # s


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, Recording, Path]:
    """A whole run, one that is recorded from BEGIN on, and the folder of that."""
    folder = tmp_path_factory.mktemp("play")
    station, meshcat = played("free_bending")
    found = []
    for is_recorded in (False, True):
        simulator = make_simulator(station)
        context = simulator.get_mutable_context()
        for port in station.parts.inputs:
            station.diagram.GetInputPort(port).FixValue(context, [80e3])
        simulator.AdvanceTo(BEGIN)
        if is_recorded:
            recorder = StationRecorder(station, meshcat, simulator, folder / "1")
            simulator.AdvanceTo(END - BEGIN)
            recorder.end()
        else:
            simulator.AdvanceTo(END)
            found.append(station.recording(context))
    return found[0], Recording.load(folder / "1" / "recording.nc"), folder / "1"


@pytest.mark.parametrize(
    ("signal", "settled"), [("plant.state", 0), ("left_finger.strain", 1), ("left_finger.external_torque", 5)]
)
def test_it_is_that_part_of_the_run(runs, signal: str, settled: int) -> None:
    """`settled` is the number of samples over which what remembers is at first without its past."""
    whole, part, _ = runs
    np.testing.assert_allclose(part[signal][settled:], whole[signal][30 + settled :], atol=1e-9)
    assert np.ptp(part[signal][settled:].values, axis=0).max() > 1e-5, "something happens in it"


def test_everything_to_look_at_it_is_there_and_whole(runs) -> None:
    _, _, folder = runs
    assert folder.name == "1"
    assert is_whole(folder)
    assert "DecompressionStream" in (folder / "animation.html").read_text()
    assert load_scenario(str(folder / "scenario.yaml")).external == ["pressure"]
