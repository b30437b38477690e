"""RecursiveEstimator: the estimator `recursive` as a block, which remembers what it has learnt."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, ValueProducer

from soft_gripper.arrays import Array
from soft_gripper.estimators.recursive_shape import Filter, RecursiveShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.shape.bending_plane import bending_plane
from soft_gripper.shape.estimate import ShapeEstimate
from soft_gripper.signals import describe

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
        super().__init__(lambda _, driving, __: function.estimate(function.begin(), driving), function.layout, gravity)
        self._recursive, self._start = function, function.begin()
        self.DeclareDiscreteState(_flat(self._start))
        self.DeclarePeriodicDiscreteUpdateEvent(function.period, 0.0, self._remember)
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc_known)
        self._known = self.DeclareCacheEntry("known", producer, {self.all_input_ports_ticket(), self.xd_ticket()})
        known = {self.cache_entry_ticket(self._known.cache_index())}
        joints = function.layout.finger.segments
        effective = self.DeclareVectorOutputPort(EFFECTIVE_DRIVING_TORQUE, joints, self._calc_driving, known)
        describe(effective, "N m", joint=range(joints))
        describe(self.DeclareVectorOutputPort("loaded", 1, self._calc_loaded, known), meanings=("free", "loaded"))

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Keeps what was known a period ago; at time 0 there is nothing."""
        if context.get_time() > 0:
            values.set_value(_flat(self._known.Eval(context)))

    def _calc_known(self, context: Context, value: AbstractValue) -> None:
        before = _unflat(context.get_discrete_state_vector().value(), self._start)
        gravity = bending_plane(self._X_WB.Eval(context)).planar(self._gravity)
        strain, driving = self._strain.Eval(context), self._driving.Eval(context)
        value.set_value(self._recursive.step(before, strain, driving, gravity))

    def _calc(self, context: Context, value: AbstractValue) -> None:
        value.set_value(self._shape(context))

    def _shape(self, context: Context) -> ShapeEstimate:
        return self._recursive.estimate(self._known.Eval(context), self._driving.Eval(context))

    def _calc_driving(self, context: Context, output: BasicVector) -> None:
        mean, driving = self._known.Eval(context).mean, self._driving.Eval(context)
        output.SetFromVector(self._recursive.effective_driving(mean, driving))

    def _calc_loaded(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._known.Eval(context).loaded))


def _flat(known: Filter) -> Array:
    return np.concatenate([np.ravel(part).astype(float) for part in known])


def _unflat(numbers: Array, like: Filter) -> Filter:
    """The filter that was flattened, of parts as large as those of another."""
    ends = np.cumsum([np.size(part) for part in like])[:-1]
    parts = (part.reshape(np.shape(own)) for part, own in zip(np.split(numbers, ends), like, strict=True))
    mean, covariance, difference, loaded, q = parts
    return Filter(mean, covariance, difference, loaded > 0, q)
