"""What is known of a load before anything is read: it is smooth, and zero beyond the tip.

Contact forces f(x) across the finger have at the arc length s the torque

    tau(s) = integral from s to L of (x - s) f(x) dx .

Let them be white noise along the finger, and one more, independent, press on the tip. Then tau is Gaussian. The
forces along the finger give it the covariance of twice integrated white noise, with u the distance from the tip over
the length,

    m^2 (3 M - m) / 2 ,   m = min(u, v) ,  M = max(u, v) ,

and the force on the tip gives it u v; each is 1 at the base. What is most probable between readings under the first
alone is a cubic spline (Wahba 1978, doi 10.1111/j.2517-6161.1978.tb01050.x).
"""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger

TIP_SHARE = 0.3  # of the variance at the base, that is due to a force on the tip


def torque_covariance(finger: Finger, load_pressure: float) -> Array:
    """Covariance of the external torque at the joints, (N m)^2, (N, N).

    At the base the standard deviation is the torque of `load_pressure`, Pa.
    """
    u = 1 - finger.joint_arc_lengths / finger.length
    less, more = np.minimum.outer(u, u), np.maximum.outer(u, u)
    along = less**2 * (3 * more - less) / 2
    covariance = TIP_SHARE * np.outer(u, u) + (1 - TIP_SHARE) * along
    return (load_pressure * finger.pressure_gain[0]) ** 2 * covariance
