"""The errors that a design of sensors really makes: sensors read fingers in statics, and estimators take them.

The oracle of `spatial_scores`. The sensors have read the way from rest to the task, and their errors are drawn anew for
every set of sensors; the nominal finger is once too stiff and once too soft. Tip and twist are those of the estimator
`gaussian`, force and place those of the most probable push (`push_finder`).

T tasks, M sets of sensors, D joints, R readings.
"""

from dataclasses import replace

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.spatial_estimator import Places
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.placement.catalogue import Design
from soft_gripper.extras.placement.push_finder import PushFinder
from soft_gripper.extras.placement.pushed_finger import PushedFinger
from soft_gripper.extras.placement.spatial_scores import Errors, errors_of_squares, wanted_of_push
from soft_gripper.extras.placement.spatial_tasks import Tasks
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

SETS = 4
_RAMP, _HELD, _PERIOD = 20, 20, 0.05  # samples of the way to the task, there, and s between them


def made_errors(
    design: Design,
    tasks: Tasks,
    nominal: list[Finger],
    errors: StrainErrors | None,
    uncertainty: Uncertainty,
    rng: np.random.Generator,
) -> Errors:
    """The root mean squares of the errors over tasks, sets of sensors and nominal fingers."""
    layout = design.layout(tasks.statics.finger)
    read = _read(layout, tasks.q, errors, rng)
    pose, push = [], []
    for finger in nominal:
        statics = replace(tasks.statics, finger=finger)
        known = replace(layout, finger=finger)
        pose.append(_pose_squares(SpatialGaussianShape(known, uncertainty), statics, read, tasks))
        find = PushFinder(known, statics, uncertainty)
        push.append(_push_squares(find, read[:, tasks.is_pushed], tasks.pushed))
    return errors_of_squares(np.array(pose), np.array(push))


def _read(layout: MeasurementModel, q: Array, errors: StrainErrors | None, rng: np.random.Generator) -> Array:
    """By sets of sensors, (M, T, R)."""
    if errors is None:
        return layout.read(q)[None]
    way = np.append(np.linspace(0, 1, _RAMP), np.ones(_HELD))[:, None, None] * q
    ideal = 1 + layout.predict(way)[:, None]
    read = disturb(errors, np.repeat(ideal, SETS, axis=1), _PERIOD, rng)[-1]
    return layout.response.reading(read)


def _pose_squares(estimate: SpatialGaussianShape, statics: PushedFinger, read: Array, tasks: Tasks) -> Array:
    """Squared errors of the tip and of the twist, (M, T, 4)."""
    true, places = tasks.q, Places(statics.finger, statics.ways)
    driving = np.broadcast_to(statics.driving(tasks.pressures), (*read.shape[:-1], true.shape[-1]))
    found = estimate(read, driving, statics.gravity).q
    tip = places(found)[0][..., -1, :] - places(true)[0][..., -1, :]
    twist = ((found - true) * np.repeat([way == "twist" for way in statics.ways], statics.finger.segments)).sum(axis=-1)
    return np.concatenate([tip, twist[..., None]], axis=-1) ** 2


def _push_squares(find: PushFinder, read: Array, tasks: Tasks) -> Array:
    """Squared errors of the force across the finger, and of its place, (M, T, 3)."""
    force, s, y = tasks.push
    true = np.concatenate([force, np.stack([s, y, np.zeros_like(s)], axis=-1)], axis=-1)
    wanted = wanted_of_push(tasks.statics.across(tasks.q, s))
    return np.asarray((wanted @ (find(read, tasks.pressures) - true)[..., None])[..., 0] ** 2)
