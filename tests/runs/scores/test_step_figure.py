"""The figure of steps: every line shows the recording whose name it has."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import same_color

from soft_gripper.diagrams.recording import Recording
from soft_gripper.runs.scores.steps import step_figure

TIME = np.arange(0.0, 1.0, 0.1)
NAMES = ("under-damped", "tuned", "over-damped")


def recording(number: int) -> Recording:
    """An opening of about `number` cm, pressures of about `number` and -`number` kPa, and a set point of 50 mm."""
    signals = {
        "left_finger.pressure": 1e3 * (number + TIME),
        "right_finger.pressure": -1e3 * (number + TIME),
        "grip.opening": 1e-2 * (number + TIME),
        "grip.set_point": np.full_like(TIME, 0.05),
    }
    return Recording(xr.Dataset({name: ("time", values) for name, values in signals.items()}, {"time": TIME}))


def test_every_line_shows_the_recording_of_its_name() -> None:
    """Openings in mm above; below, pressures of the first finger in kPa, in the colour of the opening."""
    figure = step_figure({name: recording(number) for number, name in enumerate(NAMES, start=1)})
    opening, pressure = figure.axes
    legend = opening.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [*NAMES, "set point"]
    *measured, set_point = opening.lines
    assert [line.get_label() for line in measured] == list(NAMES)
    assert list(set_point.get_ydata()) == pytest.approx([50.0] * len(TIME))
    for number, (above, below) in enumerate(zip(measured, pressure.lines, strict=True), start=1):
        assert same_color(above.get_color(), below.get_color())
        for line, expected in ((above, 10 * (number + TIME)), (below, number + TIME)):
            np.testing.assert_allclose(line.get_xdata(), TIME)
            np.testing.assert_allclose(line.get_ydata(), expected)
    assert len({line.get_color() for line in opening.lines}) == len(NAMES) + 1
    assert (opening.get_ylabel(), pressure.get_ylabel()) == ("opening [mm]", "pressure [kPa]")
    assert pressure.get_xlabel() == "time [s]"
