"""RecursiveEstimator: the estimator `recursive` as a block, which remembers what it has learnt."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from soft_gripper.arrays import Array
from soft_gripper.estimators.recursive_shape import Filter, RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.driving_torque import DRIVING_TORQUE
from soft_gripper.shape.estimate import ShapeEstimate, ShapeFunction

EFFECTIVE_DRIVING_TORQUE = "effective_driving_torque"


class RecursiveEstimator(ShapeEstimator):
    """Estimates the shape of one finger from sample to sample.

    ::

        strain (paths * S) -------> +--------------------+ ---> all outputs of ShapeEstimator
        driving_torque (N) N m ---> | RecursiveEstimator | ---> effective_driving_torque  (N) N m, see RecursiveShape
        X_WB (12) [R | p] --------> +--------------------+ ---> loaded                    (1) 0 or 1: something bends
                                                                                          the finger

    Give it inputs that are sampled together every period of its function, from time 0, in discrete state.
    """

    def __init__(self, function: RecursiveShape, gravity: Array):
        """`gravity` in the world, (3,) m/s^2, zero for none."""
        super().__init__(function, function.layout, gravity)
        joints = range(function.layout.finger.segments)
        self.put_out(
            *(EFFECTIVE_DRIVING_TORQUE, lambda known, driving: function.effective_driving(known.mean, driving)),
            *("known", DRIVING_TORQUE),
            unit="N m",
            joint=joints,
        )
        self.put_out("loaded", lambda known: float(known.loaded), "known", meanings=("free", "loaded"))

    def _derive_shape(self, function: ShapeFunction, layout: SensorLayout) -> ShapeEstimate:
        assert isinstance(function, RecursiveShape)
        self._recursive, self._start = function, function.begin()
        self.DeclareDiscreteState(_flat(self._start))
        self.DeclarePeriodicDiscreteUpdateEvent(function.period, 0.0, self._remember)
        self.remember("known", self._calc_known, "strain", DRIVING_TORQUE, "gravity")
        self.derive("shape", function.estimate, "known", DRIVING_TORQUE)
        return function.estimate(self._start, np.zeros(layout.finger.segments))

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Keeps what was known a period ago; at time 0 there is nothing."""
        if context.get_time() > 0:
            values.set_value(_flat(self.read("known", context)))

    def _calc_known(self, context: Context) -> Filter:
        before = _unflat(context.get_discrete_state_vector().value(), self._start)
        sample = (self.read(name, context) for name in ("strain", DRIVING_TORQUE, "gravity"))
        return self._recursive.step(before, *sample)


def _flat(known: Filter) -> Array:
    return np.concatenate([np.ravel(part).astype(float) for part in known])


def _unflat(numbers: Array, like: Filter) -> Filter:
    """The filter that was flattened, of parts as large as those of another."""
    ends = np.cumsum([np.size(part) for part in like])[:-1]
    parts = (part.reshape(np.shape(own)) for part, own in zip(np.split(numbers, ends), like, strict=True))
    mean, covariance, difference, loaded, q = parts
    return Filter(mean, covariance, difference, loaded > 0, q)
