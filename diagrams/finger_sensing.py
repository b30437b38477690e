"""FingerSensing: all that is known about one finger, from its joints to the errors of what is estimated."""

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, Gain, ZeroOrderHold

from soft_gripper.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.arrays import Array
from soft_gripper.force_estimator import ForceEstimator
from soft_gripper.metrics import PoseError
from soft_gripper.sensor_layout import SensorLayout
from soft_gripper.strain_sensor import StrainSensor


class FingerSensing(Diagram):
    """The blocks that follow one finger; everything they put out is a port of this one.

    joint_angles (N) rad --> StrainSensor --> ArcPoseEstimator --> PoseError
    pressure (1) Pa -------> (sampled) -----------> ForceEstimator --> external_torque_error
    contact_torque (N) N m > (sampled, the truth) -------------------/

    The pose of the finger's base, X_WB, comes in sampled, or constant.
    """

    def __init__(self, layout: SensorLayout, period: float, gravity: Array):
        """A finger of the given sensors, sampled every `period` s.

        `gravity` in the world, (3,) m/s^2, is what the force estimate is compensated for.
        """
        super().__init__()
        joints = layout.finger.segments
        builder = DiagramBuilder()
        sensor = builder.AddNamedSystem("strain_sensor", StrainSensor(layout, period))
        pressure = builder.AddNamedSystem("sampled_pressure", ZeroOrderHold(period, 1))
        truth = builder.AddNamedSystem("true_external_torque", ZeroOrderHold(period, joints))
        pose = builder.AddNamedSystem("arc_pose_estimator", ArcPoseEstimator(layout))
        pose_error = builder.AddNamedSystem("pose_error", PoseError(layout.finger))
        force = builder.AddNamedSystem("force_estimator", ForceEstimator(layout, gravity))
        minus_truth = builder.AddNamedSystem("minus_truth", Gain(-1.0, joints))
        force_error = builder.AddNamedSystem("external_torque_error", Adder(2, joints))

        builder.ExportInput(sensor.GetInputPort("joint_angles"), "joint_angles")
        builder.ExportInput(pressure.get_input_port(), "pressure")
        builder.ExportInput(truth.get_input_port(), "contact_torque")
        for source, target, signal in (
            (sensor, pose, "strain"),
            (sensor, pose_error, "sampled_joint_angles"),
            (pose, pose_error, "joint_positions"),
            (pose, pose_error, "tip_pose"),
            (pose, force, "theta"),
        ):
            builder.Connect(source.GetOutputPort(signal), target.GetInputPort(signal))
        builder.ExportInput(pose.GetInputPort("X_WB"), "X_WB")
        builder.ConnectInput("X_WB", force.GetInputPort("X_WB"))
        builder.Connect(pressure.get_output_port(), force.GetInputPort("pressure"))
        builder.Connect(truth.get_output_port(), minus_truth.get_input_port())
        builder.Connect(force.GetOutputPort("external_torque"), force_error.get_input_port(0))
        builder.Connect(minus_truth.get_output_port(), force_error.get_input_port(1))

        for block in (sensor, pose, pose_error, force):
            for i in range(block.num_output_ports()):
                port = block.get_output_port(i)
                builder.ExportOutput(port, port.get_name())
        for block in (pressure, truth, force_error):
            builder.ExportOutput(block.get_output_port(), block.get_name())
        builder.BuildInto(self)
