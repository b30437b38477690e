"""The search for the best design of a gripper, over any fields of its scenario."""

from .run_design import run_design as run_design
from .study_file import DesignStudy as DesignStudy
from .study_file import load_design_study as load_design_study
