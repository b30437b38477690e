"""changed_urdf: what is written is read again, and with a change it differs in that alone."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from soft_gripper.fingers.finger_parts import CreepBranch, ElasticLaw, TipLoad
from soft_gripper.fingers.urdf import changed_urdf, expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.finger_changes import mounted_finger

FILES = sorted([*(DIRECTORY / "grippers").glob("*.urdf"), *(DIRECTORY / "recordings").glob("*.urdf")])
TWO_FINGER = DIRECTORY / "grippers/two_finger.urdf"


def written(tmp_path, file, **options):
    path = tmp_path / "written.urdf"
    path.write_text(changed_urdf(file, **options))
    return path


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_shipped_finger_is_read_as_it_was_written(tmp_path, file):
    again, before = expand_urdf(written(tmp_path, file)), expand_urdf(file)
    assert again.fingers == before.fingers
    assert again.text == before.text


def test_parts_that_no_shipped_gripper_has(tmp_path):
    law = ElasticLaw((-3.0, 0.0, 3.0), (-0.1, 0.0, 0.1), (-0.05, 0.0, 0.06))
    parts = {"elastic_law": law, "tip_load": TipLoad(0.01, 1e-3, 2e-3), "creep": (CreepBranch(0.1, 0.3),)}
    changed = written(tmp_path, TWO_FINGER, change=lambda m: replace(m, finger=replace(m.finger, **parts)))
    for finger in expand_urdf(changed).fingers:
        assert finger.tip_load == parts["tip_load"]
        assert finger.creep == parts["creep"]
        np.testing.assert_allclose(finger.elastic_law.curvature, law.curvature, rtol=1e-14)


def test_a_tilt_turns_the_tips_toward_the_object(tmp_path):
    seen = []

    def tilted(mounted):
        seen.append(mounted_finger(mounted, "here", {"all": {"tilt": "0.1"}}))
        return seen[-1]

    expand_urdf(TWO_FINGER, change=tilted)
    directions = [RollPitchYaw(mounted.rpy).ToRotationMatrix().matrix()[:, 2].copy() for mounted in seen]
    for mounted, z in zip(seen, directions, strict=True):
        assert z[0] * mounted.xyz[0] < 0  # toward the middle
        np.testing.assert_allclose(z[2], np.cos(0.1), rtol=1e-12)
        np.testing.assert_allclose(abs(z[0]), np.sin(0.1), rtol=1e-12)
