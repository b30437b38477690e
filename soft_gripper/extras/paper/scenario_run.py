"""Runs one scenario of the evaluation, and writes all its results into a folder of its own."""

from pathlib import Path

from PIL import Image

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat, write_animation
from soft_gripper.diagrams.view.torque_colors import recorded_limit
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import EXACT
from soft_gripper.extras.paper.contact_table import contact_table
from soft_gripper.extras.paper.forces import LAYOUTS, contact_force_table
from soft_gripper.extras.paper.scenes_figure import largest_pressure
from soft_gripper.extras.paper.section_tables import force_table, pose_table
from soft_gripper.files.output import atomic_folder, is_whole
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario
from soft_gripper.scenario.schema import Scenario

FREE = "free_bending"
CONTACT = ("obstructed_inside", "obstructed_outside", "box_grasp", "irregular_grasp")
SCENARIOS = (FREE, *CONTACT)
SECTIONS = (1, 2, 3, 4)
TORQUE_OF = ("arcs", "constant_curvature")  # ours, and as published


def evaluated_scenario(name: str) -> Scenario:
    """A shipped scenario for the evaluation: the nominal model is exact, and estimators know it."""
    return load_scenario(name, [f"estimator.uncertainty.bend_per_pressure={EXACT}"])


def run_scenario(name: str, folder: Path) -> None:
    """Writes all files of a scenario into `folder`, which appears complete or not at all.

    Files: scenario.yaml, recording.nc, metrics.csv, forces.csv, contact.csv, contact_forces.csv, scene.png and
    animation.html.
    """
    scenario = evaluated_scenario(name)
    meshcat = hidden_meshcat()
    station = make_private_station(scenario, meshcat)
    _require_equal_sections(station)
    recording = run_station(station, meshcat)
    with atomic_folder(folder) as partial:
        recording.save(partial / "recording.nc")
        _picture(scenario, recording).save(partial / "scene.png")
        write_csv(partial / "metrics.csv", pose_table(name, station, recording, SECTIONS, tuple(SHAPE_FUNCTIONS)))
        write_csv(partial / "forces.csv", force_table(name, station, recording, SECTIONS, TORQUE_OF))
        write_csv(partial / "contact.csv", contact_table(name, station, recording))
        write_csv(partial / "contact_forces.csv", contact_force_table(name, station, recording, LAYOUTS))
        write_animation(meshcat, partial / "animation.html")
        (partial / "scenario.yaml").write_text(dump_scenario(scenario), encoding="utf-8")


def _picture(scenario: Scenario, recording: Recording) -> Image.Image:
    """The scene at its largest pressure, the fingers coloured by their external torque."""
    renderer = SceneRenderer(scenario, recording, height=900, width=1200, torque_limit=recorded_limit(recording))
    time, _ = largest_pressure(scenario)
    return Image.fromarray(renderer.render(time))


def is_finished(folder: Path, scenario: Scenario) -> bool:
    """Whether the folder holds a complete run of this same scenario."""
    return is_whole(folder) and (folder / "scenario.yaml").read_text(encoding="utf-8") == dump_scenario(scenario)


def _require_equal_sections(station: Station) -> None:
    """Checks that sections are of equal length, or the comparison of their numbers would be unfair."""
    for finger in station.fingers:
        for sections in SECTIONS:
            if finger.finger.segments % sections:
                expected = f"must divide the {finger.finger.segments} segments of finger '{finger.name}'"
                raise InputError("evaluate", "sections", sections, expected)
