"""Scores and measures of a run."""

from .scores.poses import held_samples as held_samples
from .scores.readings import external_torque_again as external_torque_again
from .scores.readings import read_again as read_again
from .scores.recorded_grasps import recorded_grasps as recorded_grasps
from .scores.recorded_slips import recorded_slips as recorded_slips
from .scores.recorded_task import detection_delay as detection_delay
from .scores.recorded_task import judged as judged
from .scores.steps import outcome as outcome
from .scores.steps import phase_table as phase_table
from .scores.steps import step_figure as step_figure
from .scores.steps import step_table as step_table
from .scores.steps import true_opening as true_opening
