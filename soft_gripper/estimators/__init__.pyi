"""The estimators of the shape, and the block that holds one."""

from .arc_shapes import ArcShape as ArcShape
from .arc_shapes import BendSharing as BendSharing
from .arcs import arcs_from_readings as arcs_from_readings
from .arcs import joints_on_arcs as joints_on_arcs
from .arcs import points_on_arcs as points_on_arcs
from .contact import ContactShape as ContactShape
from .driving_torque import DrivingTorque as DrivingTorque
from .estimate import ContactForce as ContactForce
from .estimate import ShapeEstimate as ShapeEstimate
from .estimate import force_along as force_along
from .finger_shape import FingerShape as FingerShape
from .finger_shape import position_std as position_std
from .gaussian import GaussianShape as GaussianShape
from .plane import planar_gravity as planar_gravity
from .plane import pose_entries as pose_entries
from .recursive import RecursiveShape as RecursiveShape
from .shape_estimator import ShapeEstimator as ShapeEstimator
from .uncertainty import Uncertainty as Uncertainty
