"""Slip, compared with displacements that are put in."""

import numpy as np
import pytest
from pick_and_place import FINGERS, box_recording, box_station, state
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.recorded_grasps import path_length
from soft_gripper.runs.scores.recorded_object import RecordedObject

pytestmark = pytest.mark.slow

LINK = 9  # at which the box is held
NOWHERE = np.full(3, np.nan)
BENT = {f"{finger}_joint_{i}": 0.03 * (i + 1) for finger in FINGERS for i in range(12)}
BENT_AGAIN = {joint: -0.5 * angle for joint, angle in BENT.items()}
ELSEWHERE = {"shoulder_pan_joint": 0.7, "elbow_joint": 0.9, "wrist_2_joint": -0.4}
X_PO = RigidTransform(RotationMatrix.MakeXRotation(0.3), [0.004, -0.002, 0.13])


@pytest.fixture(scope="module")
def station() -> Station:
    return box_station()


def pose(station, body, positions) -> RigidTransform:
    """Pose of a body of the gripper in the world at joint positions."""
    plant = station.plant
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state(station, RigidTransform(), positions))
    return plant.GetBodyByName(body).EvalPoseInWorld(context)


def slip_mm(station, placed, centers) -> float:
    """Slip while the box takes the poses `placed` in the world, each with joint positions; centres in the world."""
    signals = {"plant.state": np.array([state(station, X_WO, positions) for X_WO, positions in placed])}
    for finger in FINGERS:
        of_finger = np.full((len(placed), 3), np.nan)
        of_finger[0] = centers.get(finger, NOWHERE)
        signals[f"{finger}.contact_center"] = of_finger
    return 1e3 * RecordedObject(station, box_recording(station, signals), "box").slip(np.arange(len(placed))).max()


def face(station, finger, positions) -> np.ndarray:
    """The middle of the inner face of a link, in the world."""
    return pose(station, f"{finger}_link_{LINK}", positions) @ [0.01, 0.0, 0.005]


def test_a_box_that_moves_with_the_gripper_does_not_slip(station):
    centers = {finger: face(station, finger, BENT) for finger in FINGERS}
    placed = [(pose(station, "palm", arm) @ X_PO, arm) for arm in (BENT, {**BENT, **ELSEWHERE})]
    assert slip_mm(station, placed, centers) == pytest.approx(0, abs=1e-9)


def test_the_displacement_along_the_link_is_slip_and_that_into_it_is_not(station):
    X_WL = pose(station, f"left_finger_link_{LINK}", BENT)
    X_LO = X_WL.inverse() @ pose(station, "palm", BENT) @ X_PO
    moved = RigidTransform([0.002, 0.003, -0.004]) @ X_LO
    elsewhere = {**BENT, **ELSEWHERE}
    placed = [(X_WL @ X_LO, BENT), (pose(station, f"left_finger_link_{LINK}", elsewhere) @ moved, elsewhere)]
    centers = {"left_finger": face(station, "left_finger", BENT)}
    assert slip_mm(station, placed, centers) == pytest.approx(5.0)


def test_the_link_nearest_to_the_contact_is_the_one_that_counts(station):
    """The box goes along with it while all the joints bend the other way."""
    name = f"right_finger_link_{LINK}"
    X_LO = pose(station, name, BENT).inverse() @ pose(station, "palm", BENT) @ X_PO
    placed = [(pose(station, name, positions) @ X_LO, positions) for positions in (BENT, BENT_AGAIN)]
    centers = {"right_finger": face(station, "right_finger", BENT)}
    assert slip_mm(station, placed, centers) == pytest.approx(0, abs=1e-9)


def test_the_mean_of_both_fingers_and_the_largest_over_time(station):
    """A box is turned about the contact at one finger, which leaves the other's to move, and then turned back."""
    centers = {finger: face(station, finger, {}) for finger in FINGERS}
    left, right = centers.values()
    X_WP = pose(station, "palm", {})
    turn = X_WP.rotation() @ RotationMatrix.MakeYRotation(0.05) @ X_WP.rotation().inverse()
    about_left = RigidTransform(left) @ RigidTransform(turn, np.zeros(3)) @ RigidTransform(-left)
    placed = [(X_WP @ X_PO, {}), (about_left @ X_WP @ X_PO, {}), (X_WP @ X_PO, {})]
    along = 1e3 * np.linalg.norm(right - left) * np.sin(0.05)
    assert slip_mm(station, placed, centers) == pytest.approx(along / 2, rel=1e-6)


def test_a_box_that_turns_about_the_line_between_the_contacts_does_not_slip(station):
    centers = {finger: face(station, finger, {}) for finger in FINGERS}
    X_WP = pose(station, "palm", {})
    middle = RigidTransform(X_WP.rotation(), np.mean(list(centers.values()), axis=0))
    about_line = middle @ RigidTransform(RotationMatrix.MakeXRotation(0.5), np.zeros(3)) @ middle.inverse()
    placed = [(X_WP @ X_PO, {}), (about_line @ X_WP @ X_PO, {})]
    assert slip_mm(station, placed, centers) == pytest.approx(0, abs=1e-9)


def test_creep_adds_to_the_path_though_it_leads_back():
    """Two fingers lift an object by 0.15 mm in 1 s; then it creeps down by 0.015 mm/s for 2 and for 8 s."""
    lengths = []
    for hold in (2.0, 8.0):
        time = np.arange(0, 1 + hold + 0.005, 0.01)
        height = 1.5e-4 * np.minimum(time, 1.0) - 1.5e-5 * np.maximum(time - 1.0, 0.0)
        lengths.append(path_length(np.stack([0 * height, height], axis=-1)[:, None] * np.ones((1, 2, 1))))
    assert 1e3 * np.array(lengths) == pytest.approx([0.18, 0.27])
    assert path_length(np.zeros((5, 1, 2))) == 0
    assert np.isnan(path_length(np.zeros((5, 0, 2))))


def test_the_path_is_the_mean_of_the_fingers():
    assert path_length(np.array([[[0, 0], [0, 0]], [[3, 4], [0, 1]], [[0, 0], [0, 0]]])) == pytest.approx(6)
