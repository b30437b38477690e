"""A user's own estimator in replays."""

from soft_gripper.extras.hardware.replay.held_out import estimator_rows

OWN = "own_blocks:contact_again"


def test_replays():
    assert estimator_rows([OWN], 2) == {f"{OWN} 1": (OWN, 1), f"{OWN} 2": (OWN, 2)}
