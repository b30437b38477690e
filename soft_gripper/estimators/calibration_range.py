"""CalibrationRange: how far a finger is from the states in which it was calibrated, as a block."""

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import memoized
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.plane import to_base
from soft_gripper.sensors.calibrated_states import CalibratedStates, StateDistances
from soft_gripper.sensors.measurement import MeasurementModel

DISTANCE, FAR, DISAGREEMENT = "state_distance", "is_far", "disagreement"


class CalibrationRange(ArrayBlock):
    """Distances of one finger from the states of its calibration.

    ::

        strain (R) ---------------> +------------------+ ---> state_distance  (1 + S) of the drive, and of the readings
        driving_torque (N) N m ---> | CalibrationRange |                      of every section, in spreads
        X_WB (12) [R | p] --------> |                  | ---> is_far          (1) 1: bands are wider by more than half
                                    +------------------+ ---> disagreement    (1) distance of drive and readings
                                                              together, in spreads; NaN: not known

    `strain` holds the readings, and is called after what the sensors measure. What is wider are the estimators' bands:
    they know the same states (`Mechanics.away`). A contact makes drive and readings disagree too, for as long as it
    lasts. Stateless.
    """

    def __init__(self, layout: MeasurementModel, states: CalibratedStates, gravity: Array):
        """The nominal sensors, calibrated in some states; `gravity` in the world, (3,) m/s^2, zero for none."""
        super().__init__()
        self.take(layout.quantity, layout.readings)
        self.take(DRIVING_TORQUE, layout.finger.segments)
        self.take("X_WB", 12)

        def distances(readings: Array, driving: Array, X_WB: Array) -> StateDistances:
            inputs = layout.measured(readings), driving, to_base(X_WB, gravity)
            return memoized(CalibratedStates.distances, states, *inputs)  # with the estimator

        self.derive("distances", distances, layout.quantity, DRIVING_TORQUE, "X_WB")
        parts = ("drive", *(f"section {section}" for section in range(states.sections)))
        self.put_out(
            DISTANCE,
            lambda distances: np.concatenate([distances.drive[..., None], distances.sections], axis=-1),
            "distances",
            unit="1",
            part=parts,
        )
        self.put_out(FAR, lambda distances: states.is_far(distances).astype(float), "distances", meanings=("no", "far"))
        self.put_out(DISAGREEMENT, lambda distances: distances.agreement, "distances")
