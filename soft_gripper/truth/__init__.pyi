"""Ground truth from the simulation, against which estimates are scored."""

from .poses import PoseError as PoseError
from .poses import TruePoses as TruePoses
from .poses import fingertip_error as fingertip_error
from .poses import pose_error as pose_error
