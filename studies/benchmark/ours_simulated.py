"""Applies our estimators to simulated contacts and grasps, with exact models of the fingers."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.finger_shape import position_std
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.extras.hardware.scoring import NORMAL_95
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, gravity_torque
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import model_path
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.benchmark.benchmark_task import Estimator, Predict, Predicted, Question, Recorded
from studies.benchmark.contacts import layout
from studies.benchmark.discriminant import train_object_classifier
from studies.benchmark.grasps import FINGERS, PRESSURES, READINGS, SECTIONS
from studies.contacts.contacts import G

# Of the mean of 20 samples of a realistic sensor: gain errors and hysteresis of 1 % at strains up to 0.15, and noise;
# the model is exact.
_UNCERTAINTY = Uncertainty(reading=1.5e-3, bend_per_pressure=EXACT)


def _contact_inputs(inputs: Array) -> tuple[Array, Array, Array]:
    """Readings (T, 4), driving torque (T, N) N m and gravity (T, 3) of the inputs of contacts."""
    driving = layout().finger.pressure_torque(inputs[:, 4])
    return inputs[:, :4], driving, np.insert(inputs[:, 5:7], 1, 0.0, axis=-1)


def add_tip_std(mean: Array, finger: Finger, estimate: ShapeEstimate) -> Predicted:
    """Adds the standard deviation of an estimate of the shape, if it has one, to tips, (T, 2) m."""
    if estimate.covariance is None:
        return mean
    std = position_std(finger, estimate.q, estimate.covariance)[:, -1:]
    return mean, np.broadcast_to(std, mean.shape)


def contact_tip(name: str) -> Estimator:
    """Estimates the tip by an estimator of the shape."""

    def estimator(task: Question, train: Sequence[Recorded]) -> Predict:
        sensors = layout()
        function = estimator_function(name, sensors, _UNCERTAINTY)

        def predict(inputs: Array) -> Predicted:
            estimate: ShapeEstimate = function(*_contact_inputs(inputs))
            return add_tip_std(as_points(estimate.points(sensors.finger)[:, -1]), sensors.finger, estimate)

        return predict

    return estimator


def _contact_estimator(estimate: Callable[[ContactForce, ContactPosterior], tuple[Array, Array]]) -> Estimator:
    """Makes an estimator of a quantity of the contact, by `contact` and its posterior."""

    def estimator(task: Question, train: Sequence[Recorded]) -> Predict:
        shape = ContactShape(layout(), _UNCERTAINTY)

        def predict(inputs: Array) -> tuple[Array, Array]:
            contact_inputs = _contact_inputs(inputs)
            contact = shape(*contact_inputs).contact
            assert contact is not None
            return estimate(contact, shape.posterior(*contact_inputs))

        return predict

    return estimator


def _transverse(contact: ContactForce, posterior: ContactPosterior) -> tuple[Array, Array]:
    """Transverse force; 0 where nothing is detected."""
    assert contact.transverse_force is not None
    return _add_interval_std(contact.transverse_force, posterior.transverse_force_interval)


def _add_interval_std(force: Array, interval: Array) -> tuple[Array, Array]:
    """Forces, (T) N, 0 where NaN, with the standard deviations of 95 % intervals of their sizes, (T, 3)."""
    mean, (low, _, high) = np.nan_to_num(force), np.nan_to_num(interval, nan=0.0).T
    return mean[:, None], np.maximum(high - np.abs(mean), np.abs(mean) - low)[:, None] / NORMAL_95


def _place(contact: ContactForce, posterior: ContactPosterior) -> tuple[Array, Array]:
    """Location, with a band as wide as its likelihood set; the whole finger where nothing is detected."""
    place, arc_length_set = contact.arc_length, posterior.arc_length_set
    ends = np.where(np.isfinite(arc_length_set), arc_length_set, [0.0, layout().finger.length])
    mean = np.where(np.isfinite(place), place, ends.mean(axis=1))
    return mean[:, None], np.maximum(ends[:, 1] - mean, mean - ends[:, 0])[:, None] / NORMAL_95


contact_force = _contact_estimator(
    lambda contact, posterior: _add_interval_std(contact.force, posterior.force_interval)
)
contact_place = _contact_estimator(_place)
contact_transverse = _contact_estimator(_transverse)


@cache
def _gripper_finger() -> Finger:
    """Finger of the gripper that holds the objects."""
    return expand_urdf(model_path("package://soft_gripper/grippers/two_finger.urdf")).fingers[0]


def _grasp_estimates(inputs: Array) -> tuple[Array, Array]:
    """Joint angles, rad, and external torques at rest, N m, of grasps, (T, L, F, N) each: the fingers hang."""
    finger = _gripper_finger()
    readings = inputs.reshape(len(inputs), len(PRESSURES), len(FINGERS), READINGS)
    driving = finger.pressure_torque(np.array(PRESSURES))[:, None]
    arcs = estimator_function("arcs", SensorLayout(finger, SECTIONS), _UNCERTAINTY)
    q = arcs(readings, driving, np.array([0.0, 0.0, G])).q
    return q, finger.elastic_torque(q) - driving - gravity_torque(finger, q, G + 0j)


def grasp_shape(task: Question, train: Sequence[Recorded]) -> Predict:
    """Trains the discriminant on the estimates of the training grasps."""
    angles, torques = _grasp_estimates(np.vstack([recorded.inputs for recorded in train]))
    classes = np.vstack([recorded.outputs for recorded in train]).argmax(axis=1)
    labels = [task.outputs[shape].name for shape in classes]
    model = train_object_classifier(labels, angles, torques)
    order = [model.shapes.index(channel.name) for channel in task.outputs]
    return lambda inputs: model.probabilities(*_grasp_estimates(inputs))[:, order]
