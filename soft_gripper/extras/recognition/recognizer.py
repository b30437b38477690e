"""ObjectRecognizer: which of the known objects a gripper holds, from a grasp whose pressure rises in steps."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, InputPort, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.extras.recognition.object_classifier import ObjectClassifier
from soft_gripper.signals import describe

SAMPLES = 5  # of a level, whose mean counts
TOLERANCE = 1e3  # Pa, within which the pressure counts as that of a level
NO_LEVEL = -1


class ObjectRecognizer(LeafSystem):
    """Recognizes the object that a gripper holds, once the pressure has been at every level of a model.

    ::

        {finger}.estimated_joint_angles (N) rad ---> +------------------+
        {finger}.external_torque (N) N m ----------> | ObjectRecognizer | ---> object_probabilities (C + 1), sum 1
        {finger}.sampled_pressure (1) Pa ----------> +------------------+

    For every level, the mean of the last five samples counts at which all fingers were within 1 kPa of it, after a
    first one. The order of the levels is free; samples that are not finite are ignored. The last probability is that of
    an object of no known shape. Probabilities are NaN until every level has its samples, and again once a finger has
    less than half the pressure of the lowest level: the gripper has let go.

    Wire it to the signals of a station, which have these names, or to your own ports. All are sampled together
    every `period` s; the output is held for a period, and so is one sample late.
    """

    def __init__(self, model: ObjectClassifier, fingers: Sequence[str], period: float):
        """
        Args:
            model: trained with this gripper, pressures and number of sections.
            fingers: names of the gripper's fingers.
            period: of the samples, s.

        Raises:
            InputError: if the model is for another number of fingers.
        """
        super().__init__()
        if len(fingers) != model.fingers:
            raise InputError("ObjectRecognizer", "fingers", list(fingers), f"the model is of {model.fingers} fingers")
        self._model = model
        self._angles = self._declare(fingers, ANGLES, model.joints)
        self._torques = self._declare(fingers, "external_torque", model.joints)
        self._pressures = self._declare(fingers, "sampled_pressure", 1)
        size = 2 * model.fingers * model.joints
        self._levels = self.DeclareDiscreteState(np.full(len(model.pressures) * size, np.nan))  # means at each
        self._recent = self.DeclareDiscreteState(
            np.full(SAMPLES * size, np.nan)
        )  # at the present one, the newest first
        self._level = self.DeclareDiscreteState([NO_LEVEL])  # of the present sample
        self._probabilities = self.DeclareDiscreteState(np.full(len(model.answers), np.nan))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        port = self.DeclareStateOutputPort("object_probabilities", self._probabilities)
        describe(port, "1", shape=model.answers)

    def _declare(self, fingers: Sequence[str], signal: str, size: int) -> list[InputPort]:
        return [self.DeclareVectorInputPort(f"{finger}.{signal}", size) for finger in fingers]

    def _update(self, context: Context, values: DiscreteValues) -> None:
        pressures = _read(context, self._pressures)[:, 0]
        levels = context.get_discrete_state(self._levels).value().reshape(len(self._model.pressures), -1).copy()
        level = level_of(pressures, self._model.pressures)
        if (pressures < self._model.pressures.min() / 2).any():
            levels[:] = np.nan
        sample = np.stack([_read(context, self._angles), _read(context, self._torques)]).ravel()
        recent = context.get_discrete_state(self._recent).value().reshape(SAMPLES, -1).copy()
        if level == NO_LEVEL or level != int(context.get_discrete_state(self._level).value()[0]):
            recent[:] = np.nan
        elif np.isfinite(sample).all():
            recent = np.vstack([sample, recent[:-1]])
            levels[level] = recent.mean(axis=0) if np.isfinite(recent).all() else levels[level]
        values.set_value(self._levels, levels.ravel())
        values.set_value(self._recent, recent.ravel())
        values.set_value(self._level, [level])
        values.set_value(self._probabilities, self._classify(levels))

    def _classify(self, levels: Array) -> Array:
        """Probabilities (C + 1) from what was seen at each level, (L, 2 F N)."""
        if not np.isfinite(levels).all():
            return np.full(len(self._model.answers), np.nan)
        angles, torques = np.moveaxis(levels.reshape(len(levels), 2, self._model.fingers, -1), 1, 0)
        return self._model.probabilities(angles, torques)


def level_of(pressures: Array, levels: Array) -> int:
    """The level at which all pressures (F) are, Pa; NO_LEVEL: none of them."""
    near = (np.abs(pressures - levels[:, None]) < TOLERANCE).all(axis=-1)
    return int(np.argmax(near)) if near.any() else NO_LEVEL


def _read(context: Context, ports: Sequence[InputPort]) -> Array:
    return np.array([port.Eval(context) for port in ports])
