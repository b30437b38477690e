"""Our estimators as those of the benchmark; what they assume is known, and nothing is trained."""

from collections.abc import Callable, Sequence

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.benchmark.baselines import Estimator, Predict
from soft_gripper.benchmark.contacts import layout
from soft_gripper.benchmark.tasks import Recorded, Task
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.uncertainty import Uncertainty, position_std
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.runs.estimator_functions import estimator_function

# Of the mean of 20 samples of a realistic sensor: gain errors and hysteresis of 1 % at strains up to 0.15, and noise.
_UNCERTAINTY = Uncertainty(reading=1.5e-3)
_BAND = 1.959964


def _known(inputs: Array) -> tuple[Array, Array, Planar]:
    """Readings (T, 4), driving torque (T, N) N m and gravity (T,) of the inputs of contacts."""
    driving = layout().finger.pressure_torque(inputs[:, 4])
    return inputs[:, :4], driving, inputs[:, 6] + 1j * inputs[:, 5]


def _tip(name: str) -> Estimator:
    """The tip, by an estimator of the shape; its standard deviation across the finger, if it has one, for both axes."""

    def estimator(task: Task, train: Sequence[Recorded]) -> Predict:
        sensors = layout()
        function = estimator_function(name, sensors, _UNCERTAINTY)

        def predict(inputs: Array) -> Array | tuple[Array, Array]:
            found: ShapeEstimate = function(*_known(inputs))
            mean = as_points(found.points(sensors.finger)[:, -1])
            if found.covariance is None:
                return mean
            std = position_std(sensors.finger, found.q, found.covariance)[:, -1:]
            return mean, np.broadcast_to(std, mean.shape)

        return predict

    return estimator


def _contact(of: Callable[[ContactShape, Array], tuple[Array, Array]]) -> Estimator:
    """What `contact` says of the contact."""

    def estimator(task: Task, train: Sequence[Recorded]) -> Predict:
        found = ContactShape(layout(), _UNCERTAINTY)
        return lambda inputs: of(found, inputs)

    return estimator


def _force(found: ContactShape, inputs: Array) -> tuple[Array, Array]:
    """The force, with a band as wide as the 95 % interval of its posterior; 0 where nothing is detected."""
    known = _known(inputs)
    contact, posterior = found(*known).contact, found.posterior(*known)
    assert contact is not None
    low, _, high = np.nan_to_num(posterior.force_interval, nan=0.0).T
    mean = np.nan_to_num(contact.force)
    return mean[:, None], np.maximum(high - np.abs(mean), np.abs(mean) - low)[:, None] / _BAND


def _place(found: ContactShape, inputs: Array) -> tuple[Array, Array]:
    """The location, with a band as wide as its likelihood set; the middle, and all of it, where nothing is detected."""
    length, known = layout().finger.length, _known(inputs)
    contact, posterior = found(*known).contact, found.posterior(*known)
    assert contact is not None
    ends = np.where(np.isfinite(posterior.arc_length_set), posterior.arc_length_set, [0.0, length])
    mean = np.where(np.isfinite(contact.arc_length), contact.arc_length, ends.mean(axis=1))
    return mean[:, None], np.maximum(ends[:, 1] - mean, mean - ends[:, 0])[:, None] / _BAND


OURS: dict[str, dict[str, Estimator]] = {
    "contact_tip": {name: _tip(name) for name in ("arcs", "gaussian", "contact")},
    "contact_force": {"contact": _contact(_force)},
    "contact_place": {"contact": _contact(_place)},
}
