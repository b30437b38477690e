"""HandledObject: where the object is and what presses on it, in a context."""

import numpy as np
from pydrake.math import RigidTransform

from soft_gripper.extras.learning.episode_variation import Draw, apply_draw
from soft_gripper.extras.learning.station import PeakForce
from soft_gripper.extras.learning.tasks import HandledObject


def begun(station):
    """An object that begins 3 mm off, in a context."""
    context = station.diagram.CreateDefaultContext()
    apply_draw(station, context, Draw(offset=3e-3))
    handled = HandledObject(station)
    handled.begin(context, np.random.default_rng())
    return handled, context


def test_its_place_is_counted_from_where_the_episode_began(grasp_station):
    handled, context = begun(grasp_station)
    np.testing.assert_array_equal(handled.look(context).place, np.zeros(3))
    assert handled.begins_at[0] == 3e-3
    plant, body = grasp_station.parts.plant, grasp_station.object
    X_WO = RigidTransform(handled.begins_at + np.array([0.01, 0.0, 0.02]))
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, X_WO)
    np.testing.assert_allclose(handled.look(context).place, [0.01, 0.0, 0.02], atol=1e-15)


def test_the_peak_is_that_of_the_finger_that_has_pressed_hardest(grasp_station):
    handled, context = begun(grasp_station)
    own = grasp_station.forces.GetMyMutableContextFromRoot(context)
    own.SetDiscreteState([0.3, 0.7])
    seen = handled.look(context)
    assert seen.peak == 0.7
    assert not seen.force.any()


def test_the_peak_is_no_less_than_what_presses_between_its_samples(grasp_station, monkeypatch):
    monkeypatch.setattr(PeakForce, "_now", lambda *_: np.array([0.9, 0.1]))
    handled, context = begun(grasp_station)
    assert handled.look(context).peak == 0.9
