"""An estimator of your own, named in a scenario.

It smoothes the bend of the sections along the finger.
"""

import numpy as np
from pydrake.systems.framework import LeafSystem

import soft_gripper as sg


class SmoothBend(LeafSystem):
    """Lets the bend change linearly between the middles of the sections."""

    def __init__(self, layout):
        super().__init__()
        self.layout = layout
        joints = layout.finger.segments
        self.strain = self.DeclareVectorInputPort("strain", layout.readings)
        port = self.DeclareVectorOutputPort(
            "estimated_joint_angles", joints, self.estimate
        )
        sg.describe(port, "rad", joint=range(joints))

    def estimate(self, context, output):
        strain = self.strain.Eval(context)
        lengths = self.layout.rest_lengths
        theta = sg.estimators.arcs_from_readings(self.layout, strain).theta
        middles = np.cumsum(lengths) - lengths / 2
        joints = self.layout.finger.joint_arc_lengths
        angles = np.interp(joints, middles, theta / lengths)
        if angles.any():
            angles *= theta.sum() / angles.sum()  # as much in total as read
        output.SetFromVector(angles)


def make(layout, gravity, period):
    """The function that the scenario names, of nominal sensors."""
    return SmoothBend(layout)


if __name__ == "__main__":
    # The same in a file: `estimator: { type: "own_estimator:make" }`.
    changes = [
        "estimator.type=own_estimator:make",
        "pressure.hold_samples=10",
    ]
    recording = sg.simulate(sg.load_scenario("obstructed_inside", changes))
    signals = (
        "estimated_joint_angles",
        "pose_error",
        "external_torque_error",
    )
    figure = recording.plot(
        *(f"left_finger.{signal}" for signal in signals)
    )
