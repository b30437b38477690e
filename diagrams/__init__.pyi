"""The wiring: scenarios -> diagrams -> recordings."""

from .recording import phase_spans as phase_spans
from .simulation import solver_config as solver_config
from .view.torque_colors import add_torque_bar as add_torque_bar
from .wiring.estimation import FingerEstimation as FingerEstimation
