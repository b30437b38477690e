"""The wiring: scenarios -> diagrams -> recordings."""

from .contact_forces import ContactForces as ContactForces
from .contact_forces import FingerForce as FingerForce
from .recording import phase_spans as phase_spans
from .simulation import solver_config as solver_config
from .view.torque_colors import add_torque_bar as add_torque_bar
from .wiring.estimation import FingerEstimation as FingerEstimation
