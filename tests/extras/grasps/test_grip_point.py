"""Grip points: the link on which a contact lies."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.extras.grasps.grip_point import grip_at
from soft_gripper.models import DIRECTORY


def test_a_contact_is_gripped_by_the_link_on_whose_face_it_lies():
    """Close to either end of a link: the points of contact move with it, not with the next one."""
    plant = MultibodyPlant(0.01)
    (finger,) = add_fingers(Parser(plant), DIRECTORY / "grippers/finger.urdf")
    plant.WeldFrames(plant.world_frame(), finger.base.body_frame())
    plant.Finalize()
    context = plant.CreateDefaultContext()
    for joint in finger.joints:
        joint.set_angle(context, 0.05)
    length = finger.finger.segment_length
    for link in finger.links[2:-2]:
        for along in (0.1 * length, 0.9 * length):
            on_link = np.array([0.009, 0.001, along])
            grip = grip_at(context, finger, RigidTransform([0.1, 0, 0]), link.EvalPoseInWorld(context) @ on_link)
            assert grip.link is link
            np.testing.assert_allclose(grip.on_link, on_link, atol=1e-12)
