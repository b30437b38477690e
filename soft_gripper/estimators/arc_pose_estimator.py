"""ArcPoseEstimator: the arcs of a finger as a block, strain -> pose."""

from operator import attrgetter

from soft_gripper.arrays import Array
from soft_gripper.estimators.arc_shapes import ArcShape
from soft_gripper.estimators.estimate import ShapeEstimate, ShapeFunction
from soft_gripper.estimators.shape_estimator import ShapeEstimator, straight_shape
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import strain_sensors


class ArcPoseEstimator(ShapeEstimator):
    """Estimates the pose of one finger, a circular arc for each sensor section: equations (2) to (6) of the paper.

    ::

        strain (R) ---------------> +------------------+ ---> tip_pose               (3) x, z, heading in B
        driving_torque (N) N m ---> | ArcPoseEstimator | ---> joint_positions        (N x 2) x, z; m in B
        X_WB (12) [R | p] --------> |                  | ---> theta                  (S) rad, bend of each section
                                    |                  | ---> kappa                  (S) 1/m, its curvature
                                    |                  | ---> arcs                   (S x 7) as of FingerShape
                                    |                  | ---> joint_positions_world  (N x 3) m, with X_WB
                                    +------------------+ ---> estimated_joint_angles (N) rad, with X_WB and
                                                                                     driving_torque

    The arcs follow from `strain` alone: connect `X_WB` for positions in the world, and with it `driving_torque` for the
    joint angles, which share the bend of a section as stiffness, driving torque and weight require (`ArcShape`);
    a ForceEstimator takes these. Where a reading is not finite, its arc and all that follows is NaN. Stateless.
    """

    def __init__(self, layout: MeasurementModel, gravity: Array):
        """The nominal sensors, a `SensorLayout`, and finger; `gravity` in the world, (3,) m/s^2, zero for none.

        Raises:
            InputError: if the sensors are not strain sensors along the two sides.
        """
        super().__init__(ArcShape(strain_sensors(layout, "ArcPoseEstimator")), layout, gravity)

    def _derive_shape(self, function: ShapeFunction, layout: MeasurementModel, gravity: Array) -> ShapeEstimate:
        assert isinstance(function, ArcShape)
        self.derive("curve", function.curve, layout.quantity)
        self.derive("shape", function.shape, "curve", self.driving, "gravity")
        self.derive("q", attrgetter("q"), "shape")
        return straight_shape(function, layout)
