"""Runs shipped scenarios for their pages: `python docs/site/store_scenarios.py [NAME ...]`, all by default.

Keeps a picture of each, and whether it met each of its criteria of success. Fails if it did not.
"""

import sys

from links import ROOT
from PIL import Image

import soft_gripper as sg
from soft_gripper.diagrams.recording import Recording, phase_spans
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.scenes_figure import largest_pressure
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.runs.success import success_rows
from soft_gripper.scenario.shipped import scenario_names

FOLDER = ROOT / "docs" / "scenarios"
_HEIGHT, _WIDTH = 420, 640  # pixels


def store(name: str) -> bool:
    """Runs a scenario and keeps its picture and its success; whether all criteria are met."""
    station = sg.make_station(sg.load_scenario(name))
    recording = sg.run_station(station)
    rows = success_rows(station, recording)
    write_csv(FOLDER / f"{name}.csv", rows)
    renderer = SceneRenderer(station.scenario, recording, height=_HEIGHT, width=_WIDTH)
    picture = Image.fromarray(renderer.render(_moment(station, recording)))
    picture.save(FOLDER / f"{name}.webp", quality=80, method=6)
    for row in rows:
        print(f"{name}: {'met' if row.met else 'NOT MET'}: {row.criterion} ({row.measured})", flush=True)
    return all(row.met for row in rows)


def _moment(station: Station, recording: Recording) -> float:
    """When there is most to see, s: while the object is carried, at the largest pressure, or at the end."""
    scenario, end = station.scenario, float(recording["time"][-1])
    if station.task is not None:
        spans = phase_spans(recording, station.task.phases)
        carrying = [span for span in spans if span.phase.holds] or spans[len(spans) // 2 :]
        return (carrying[0].begin + carrying[0].end) / 2 if len(carrying) < 2 else carrying[-2].begin
    time, pressure = largest_pressure(scenario)
    return time if pressure and scenario.control.set_points is None else end


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    met = [store(name) for name in sys.argv[1:] or scenario_names()]
    sys.exit(not all(met))
