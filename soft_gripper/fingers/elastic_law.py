"""ElasticLawTorque: what an elastic law of the user's adds to the linear springs of the chain."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain, Multiplexer, Saturation

from soft_gripper.fingers.finger import Finger


class ElasticLawTorque(Diagram):
    """Torque that turns the linear springs of a finger into its elastic law, all of Drake's C++ primitives.

    ::

                                   +------------------+
        joint_angles (N) rad ----> | ElasticLawTorque | ---> torque  (N) N m = stiffness * q - law(q)
                                   +------------------+

    A piecewise linear curve is a sum: for every piece, its slope times the angle, held within the piece. So
    there is one Saturation a piece, a MatrixGain of the slopes, and a constant.
    """

    def __init__(self, finger: Finger):
        super().__init__()
        law, joints = finger.joint_law, finger.segments
        angles = law.x[0]
        lower, upper = np.append(-np.inf, angles[1:-1]), np.append(angles[1:-1], np.inf)
        slopes = finger.stiffness[:, None] - law.slopes
        offset = -law(np.zeros(joints)) - slopes @ np.clip(0.0, lower, upper)
        builder = DiagramBuilder()
        pieces = [Saturation(np.full(joints, low), np.full(joints, up)) for low, up in zip(lower, upper, strict=True)]
        together = builder.AddNamedSystem("pieces", Multiplexer([joints] * len(pieces)))
        weights = np.hstack([np.diag(slope) for slope in slopes.T])
        weighted = builder.AddNamedSystem("slopes", MatrixGain(weights))
        constant = builder.AddNamedSystem("offset", ConstantVectorSource(offset))
        total = builder.AddNamedSystem("sum", Adder(2, joints))
        for i, piece in enumerate(pieces):
            builder.AddNamedSystem(f"piece_{i}", piece)
            builder.Connect(piece.get_output_port(), together.get_input_port(i))
            if i == 0:
                builder.ExportInput(piece.get_input_port(), "joint_angles")
            else:
                builder.ConnectInput("joint_angles", piece.get_input_port())
        builder.Connect(together.get_output_port(), weighted.get_input_port())
        builder.Connect(weighted.get_output_port(), total.get_input_port(0))
        builder.Connect(constant.get_output_port(), total.get_input_port(1))
        builder.ExportOutput(total.get_output_port(), "torque")
        builder.BuildInto(self)
