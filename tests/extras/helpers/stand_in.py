"""An analytic stand-in for a simulation of `bottle_grasp`: a grasp whose best design is known.

With a finger length L, a pressure p and a friction mu, the fingers press with  F = k p / L  and the object is held if
mu F is at least its weight; the slip ratio is the weight over mu F. Least force is at the longest finger, and at the
pressure that just holds with the least friction.
"""

WEIGHT, GAIN = 0.6, 1.2e-6  # N; m^2
LENGTH, PRESSURE = "models.gripper.fingers.all.length", "pressure.steps.all.0"
FRICTION = "models.bottle.friction"


def force(changes):
    return GAIN * changes.get(PRESSURE, 120e3) / changes.get(LENGTH, 0.12)


def grasped(scenario, runs, own=()):
    """The measures of each run."""
    return [*map(_measures, runs)]


def _measures(changes):
    pressed = force(changes)
    ratio = WEIGHT / (changes.get(FRICTION, 0.8) * pressed)
    return {"grasp": "held" if ratio <= 1 else "dropped", "normal_force_n": pressed, "slip_ratio": ratio}
