"""DrawnFinger: the pieces of a curve cover its sections, whatever their lengths."""

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex

from soft_gripper.diagrams.view.estimate_visualizer import DrawnFinger
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.mark.parametrize("borders", [None, (0.25,), (1 / 3, 0.5)])
def test_pieces_cover_their_sections(shipped_finger: Finger, borders: tuple[float, ...] | None) -> None:
    layout = SensorLayout(shipped_finger, 2 if borders is None else len(borders) + 1, borders=borders)
    drawn = DrawnFinger("finger", shipped_finger, layout.section_ends, BodyIndex(0), ())
    assert drawn.sections == layout.sections
    of_sections = drawn.piece_lengths.reshape(layout.sections, drawn.pieces)
    np.testing.assert_allclose(of_sections.sum(axis=1), layout.rest_lengths)
    assert len(drawn.piece_lengths) >= 2 * shipped_finger.segments
