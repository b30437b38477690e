"""How well objects are grasped: trials of a task over random objects, and the strength of one grasp."""

from .adds import TrialsConfig as TrialsConfig
from .strength import Shake as Shake
from .strength import grasp_strength as grasp_strength
from .strength import strength_figure as strength_figure
