"""An estimator of your own, named in a scenario: the bend of every section, smoothed along the finger."""

import numpy as np
from pydrake.systems.framework import LeafSystem

import soft_gripper as sg


class SmoothBend(LeafSystem):
    """Lets the bend change linearly between the middles of the sections, with the measured total."""

    def __init__(self, layout):
        super().__init__()
        self.layout, joints = layout, layout.finger.segments
        self.strain = self.DeclareVectorInputPort("strain", layout.readings)
        port = self.DeclareVectorOutputPort("estimated_joint_angles", joints, self.estimate)
        sg.describe(port, "rad", joint=range(joints))

    def estimate(self, context, output):
        theta = sg.estimators.arcs_from_readings(self.layout, self.strain.Eval(context)).theta
        middles = np.cumsum(self.layout.rest_lengths) - self.layout.rest_lengths / 2
        curvature = np.interp(self.layout.finger.joint_arc_lengths, middles, theta / self.layout.rest_lengths)
        output.SetFromVector(curvature * theta.sum() / curvature.sum() if curvature.any() else curvature)


def make(layout, gravity, period):
    """The function that the scenario names; `layout` has the nominal sensors and finger."""
    return SmoothBend(layout)


if __name__ == "__main__":
    # The same in a file: `estimator: { type: "own_estimator:make" }`.
    scenario = sg.load_scenario("obstructed_inside", ["estimator.type=own_estimator:make", "pressure.hold_samples=10"])
    recording = sg.simulate(scenario)
    signals = ("estimated_joint_angles", "pose_error", "external_torque_error")
    figure = recording.plot(*(f"left_finger.{signal}" for signal in signals))
