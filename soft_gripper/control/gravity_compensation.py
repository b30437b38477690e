"""GravityCompensation: the torques that compensate the weight of an arm."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import Diagram, DiagramBuilder


class GravityCompensation(Diagram):
    """Drake's InverseDynamics for gravity alone, together with the plant that it needs.

    ::

        state (2 n) ---> GravityCompensation ---> torque (n) N m or N, of the joints in the order of their velocities
    """

    def __init__(self, arm: MultibodyPlant):
        """`arm` is a finalized plant of the arm alone, with its load."""
        super().__init__()
        self._arm = arm  # InverseDynamics does not keep it alive
        builder = DiagramBuilder()
        mode = InverseDynamics.InverseDynamicsMode.kGravityCompensation
        dynamics = builder.AddNamedSystem("inverse_dynamics", InverseDynamics(arm, mode))
        builder.ExportInput(dynamics.get_input_port_estimated_state(), "state")
        builder.ExportOutput(dynamics.get_output_port(), "torque")
        builder.BuildInto(self)
