"""FingerSensing: all that is known about one finger, from its joints to the errors of its estimate."""

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource

from soft_gripper.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.metrics import PoseError
from soft_gripper.sensor_layout import SensorLayout
from soft_gripper.strain_sensor import StrainSensor


class FingerSensing(Diagram):
    """StrainSensor -> ArcPoseEstimator -> PoseError; every output port of the three is a port of this one.

    Input: joint_angles (N) rad.
    """

    def __init__(self, layout: SensorLayout, period: float, X_WB: RigidTransform):
        """A finger of the given sensors, sampled every `period` s, on a base that stands at `X_WB`."""
        super().__init__()
        builder = DiagramBuilder()
        base = builder.AddNamedSystem("base_pose", ConstantValueSource(Value(X_WB)))
        sensor = builder.AddNamedSystem("strain_sensor", StrainSensor(layout, period))
        estimator = builder.AddNamedSystem("arc_pose_estimator", ArcPoseEstimator(layout))
        error = builder.AddNamedSystem("pose_error", PoseError(layout.finger))

        builder.ExportInput(sensor.GetInputPort("joint_angles"), "joint_angles")
        builder.Connect(sensor.GetOutputPort("strain"), estimator.GetInputPort("strain"))
        builder.Connect(base.get_output_port(), estimator.GetInputPort("X_WB"))
        for source, signal in (
            (sensor, "sampled_joint_angles"),
            (estimator, "joint_positions"),
            (estimator, "tip_pose"),
        ):
            builder.Connect(source.GetOutputPort(signal), error.GetInputPort(signal))
        for block in (sensor, estimator, error):
            for i in range(block.num_output_ports()):
                port = block.get_output_port(i)
                builder.ExportOutput(port, port.get_name())
        builder.BuildInto(self)
