"""Fits, tests and what cannot be told apart, together."""

from dataclasses import replace

import pytest
from identified import LET_GO, RELEASE, recorded, release

from soft_gripper.extras.hardware.identification.identified_finger import identify, identify_figure


def test_weight_and_modulus_cannot_be_told_apart(beam, pool):
    """All torques of an unloaded beam are in proportion to either."""
    found = identify(beam, ["youngs_modulus", "density"], [recorded(beam, release(0.8))], [], pool)
    (dropped,) = found.confidence.undetermined
    assert (dropped.name, dropped.beside) == ("density", ("youngs_modulus",))
    assert dropped.correlation == pytest.approx(1, abs=0.02)
    assert dropped.value == found.model.finger.base.density
    alone = identify(beam, ["youngs_modulus"], [recorded(beam, release(0.8))], [], pool)
    assert found.confidence.names == ["youngs_modulus"]
    assert found.confidence.std == pytest.approx(alone.confidence.std, rel=0.1)


@pytest.mark.slow
def test_recordings_that_test_change_nothing_but_their_events(beam, pool):
    motion = recorded(beam, release(0.8))
    other = replace(recorded(beam, release(0.8), seed=1), name="other", events=(RELEASE + 0.02, LET_GO + 0.02))
    alone = identify(beam, ["youngs_modulus"], [motion], [], pool)
    found = identify(beam, ["youngs_modulus"], [motion], [other], pool)
    assert found.model == alone.model
    assert [score.role for score in found.scores] == ["fit", "test"]
    assert found.motions[1].events == pytest.approx((RELEASE, LET_GO), abs=2e-3)
    assert found.scores[1].motion_error_mm < 0.05
    assert [axes.get_title() for axes in identify_figure(found).axes[:2]] == ["released\nfitted", "other\nheld out"]
