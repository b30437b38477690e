"""The evaluation of robustness: what is left to run, and what comes of all of it."""

from dataclasses import dataclass
from pathlib import Path

from soft_gripper.evaluation.figure_style import save_figure
from soft_gripper.evaluation.paper.claims import Claim
from soft_gripper.evaluation.robustness.map_figure import map_figure
from soft_gripper.evaluation.robustness.maps import FOLDER, gather_maps
from soft_gripper.evaluation.robustness.plant_runs import gather_plants
from soft_gripper.evaluation.robustness.plant_table import PlantRow
from soft_gripper.evaluation.robustness.robustness_claims import robustness_claims
from soft_gripper.evaluation.robustness.robustness_table import RobustnessRow


@dataclass(frozen=True)
class Robustness:
    """The tables of all cases and plants, and what follows from them."""

    rows: list[RobustnessRow]
    plants: list[PlantRow]
    claims: list[Claim]


def summarize_robustness(out: Path) -> Robustness:
    """Writes the tables and the map from the finished cases and plants below the folder `out` of the evaluation."""
    rows, plants = gather_maps(out), gather_plants(out)
    save_figure(map_figure(rows), out / FOLDER / "robustness")
    return Robustness(rows, plants, robustness_claims(rows, plants))
