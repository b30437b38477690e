"""The evaluation: scenarios side by side in processes, then the tables, figures and claims of them all."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.sensors import sensor_layout
from soft_gripper.evaluation.csv_table import read_csv, write_csv
from soft_gripper.evaluation.figure_style import save_figure
from soft_gripper.evaluation.paper.claims import Claim, claims
from soft_gripper.evaluation.paper.difference_figure import difference_figure
from soft_gripper.evaluation.paper.figures import contact_figure, free_bending_figure
from soft_gripper.evaluation.paper.force_figure import force_figure
from soft_gripper.evaluation.paper.force_table import ForceRow
from soft_gripper.evaluation.paper.pose_table import PoseRow
from soft_gripper.evaluation.paper.report import write_report
from soft_gripper.evaluation.paper.scenario_run import is_finished, run_scenario
from soft_gripper.evaluation.processes import call_in_processes, report
from soft_gripper.files import remove_partial
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.scenes_figure import scenes_figure
from soft_gripper.pictures.shape_figure import shape_figure

FREE = "free_bending"
CONTACT = ("obstructed_inside", "obstructed_outside", "box_grasp", "irregular_grasp")
SCENARIOS = (FREE, *CONTACT)
CAPTIONS = {
    "fig8_scenarios": "The scenarios as they begin and at their largest pressure (the paper's Fig. 8), the fingers"
    " coloured by the external torque at their joints.",
    "fig4_shape": "A finger obstructed inside (Fig. 4): the simulation, the estimated arcs, the estimate.",
    "fig5_free_bending": "Free bending (Fig. 5): errors of the estimated pose against the bend angle.",
    "difference": "Why the paper's fingertip error in free bending hardly depends on the number of sensors: with joints"
    " where the segments begin, half of the first joint's angle is turned before the sensors begin, and none sees it.",
    "fig6_pose_error": "Contact (Fig. 6): mean pose error against the pressure.",
    "fig7_fingertip_error": "Contact (Fig. 7): fingertip error against the pressure.",
    "force_estimate": "External torque along the first finger at the last step, and its mean error against pressure.",
}
Advance = Callable[[float], Any]


@dataclass(frozen=True)
class Evaluation:
    """The tables of all scenarios, and what follows from them."""

    poses: list[PoseRow]
    forces: list[ForceRow]
    claims: list[Claim]


def unfinished(out: Path) -> list[str]:
    """Scenarios of which `out` holds no whole run."""
    return [name for name in SCENARIOS if not is_finished(out / name, load_scenario(name))]


def run_scenarios(names: Sequence[str], out: Path, jobs: int, advance: Advance) -> None:
    """Runs scenarios in `jobs` processes, each into its own folder below `out`.

    Args:
        advance: called with the seconds of simulated time that were added, of all scenarios together.

    Raises:
        InputError, SimulationDivergedError: if a scenario fails; the others are finished first.
    """
    longest_first = sorted(names, key=lambda name: -len(load_scenario(name).models))
    finished: list[Future[None]] = []
    calls = [(name, out / name) for name in longest_first]
    try:
        call_in_processes(_work, calls, jobs, lambda _, future: finished.append(future), advance)
    except KeyboardInterrupt:
        for name in names:
            remove_partial(out / name)
        raise
    for future in finished:
        future.result()


def _work(name: str, folder: Path) -> None:
    last = 0.0

    def advance(time: float) -> None:
        nonlocal last
        report(time - last)
        last = time

    run_scenario(name, folder, advance)


def summarize(out: Path) -> Evaluation:
    """Writes the tables, the figures and the report from the finished scenarios in `out`."""
    poses = [row for name in SCENARIOS for row in read_csv(out / name / "metrics.csv", PoseRow)]
    forces = [row for name in SCENARIOS for row in read_csv(out / name / "forces.csv", ForceRow)]
    found = claims(poses, forces)
    write_csv(out / "metrics.csv", poses)
    write_csv(out / "forces.csv", forces)
    for name, figure in _figures(out, poses, forces).items():
        save_figure(figure, out / name)
    write_report(out, SCENARIOS, poses, found, CAPTIONS)
    return Evaluation(poses, forces, found)


def _figures(out: Path, poses: list[PoseRow], forces: list[ForceRow]) -> dict[str, Figure]:
    """All figures, by the names of `CAPTIONS`."""
    runs = {name: (load_scenario(name), Recording.load(out / name / "recording.nc")) for name in SCENARIOS}
    scenario, recording = runs["obstructed_inside"]
    layout = sensor_layout(_finger(scenario), scenario.sensor)
    return {
        "fig4_shape": shape_figure(layout, recording, scenario.duration),
        "difference": difference_figure(*runs[FREE], _finger(runs[FREE][0])),
        "fig5_free_bending": free_bending_figure([row for row in poses if row.scenario == FREE]),
        "fig6_pose_error": contact_figure(poses, CONTACT, "pose_error_mm"),
        "fig7_fingertip_error": contact_figure(poses, CONTACT, "tip_error_mm"),
        "fig8_scenarios": scenes_figure(runs),
        "force_estimate": force_figure(forces, CONTACT),
    }


def _finger(scenario: Scenario) -> Finger:
    """The first finger of a scenario."""
    return make_station(scenario).fingers[0].finger
