"""What recordings of made-up motions say: events, turns, settled places, and what is wrong with them."""

from dataclasses import replace

import numpy as np
import pytest
from identified import CLOSES, OPENS, REFERENCE, RELEASE, RELEASED, STEPPED, write_motion
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.identification.simulated_motion import marker_rotation, measured_motion, settled_mean
from soft_gripper.extras.hardware.recording_schema import PoseConfig, load_description
from soft_gripper.extras.hardware.recordings import read_recording

TIME = np.arange(0, 2, 0.01)
FALLS = 0.02j * np.clip((TIME - RELEASE) / 0.1, 0, 1)
RISES_AND_FALLS = FALLS - 0.02j * np.clip((TIME - CLOSES) / 0.1, 0, 1)


@pytest.fixture
def recording(tmp_path):
    """The recording of markers that are displaced together, m, as it is read from its file."""

    def read(displacement, description=RELEASED, name="run"):
        (tmp_path / "described.yaml").write_text(description)
        markers = REFERENCE + displacement[:, None]
        file = write_motion(tmp_path / f"{name}.csv", TIME, markers)
        return read_recording(file, load_description(tmp_path / "described.yaml"))

    return read


def test_turn_is_that_of_least_squares():
    markers = REFERENCE * np.exp(0.3j) + 1e-3 * np.array([1 + 2j, -2j, -3 + 1j])
    found = float(marker_rotation(markers, REFERENCE))

    def off(angle):
        moved = np.exp(1j * angle) * (REFERENCE - REFERENCE.mean())
        return np.sum(np.abs(markers - markers.mean() - moved) ** 2)

    assert off(found) < min(off(found - 1e-3), off(found + 1e-3))


def test_settled_is_the_mean_of_the_last_fifth_of_a_second():
    time = np.arange(0, 2, 0.01)
    assert settled_mean(time, time, 1.5) == pytest.approx(1.5 - (0.2 - 0.01) / 2)
    values = np.where(time > 1.45, np.nan, 3.0)
    assert settled_mean(time, values, 1.5) == 3.0


def test_release_is_when_it_begins_to_move(recording):
    motion = measured_motion(recording(FALLS))
    assert motion.events[0] == pytest.approx(RELEASE + 0.1 * 0.1, abs=0.0101)
    assert motion.largest == pytest.approx(0.02)
    assert motion.events[1] > motion.events[0]
    assert motion.end == TIME[-1]
    assert motion.pressure is None
    np.testing.assert_allclose(motion.gravity, [9.81, 0, 0])


def test_valve_opens_and_closes(recording):
    motion = measured_motion(recording(RISES_AND_FALLS, STEPPED, "run_30kPa"))
    assert motion.events == pytest.approx([OPENS, CLOSES], abs=0.0201)
    assert motion.pressure == pytest.approx(30e3)
    assert motion.end == motion.events[1]


def test_load_hangs_where_it_is_said_to(recording):
    description = RELEASED + "load: {pattern: 'load_{number}'}\nload_place: [-0.015, 0.002]\n"
    load = measured_motion(recording(FALLS, description, "load_52g")).load
    assert (load.mass, load.x, load.z) == pytest.approx((0.052, -0.015, 0.002))


def test_load_hangs_on_its_string(recording):
    described = RELEASED + "load_string: 0.2\n"
    assert measured_motion(recording(FALLS, described)).string == 0.2
    with refused("gravity", None):
        measured_motion(recording(FALLS, described.replace("gravity: [9.81, 0, 0]\n", "")))


@pytest.mark.parametrize(
    ("displacement", "description", "name", "field", "value"),
    [
        (
            FALLS,
            RELEASED.replace("tip: [tip_1, tip_2, tip_3]", "base: [tip_1, tip_2]"),
            "run",
            "markers.bodies.tip",
            [],
        ),
        (FALLS, RELEASED.replace("event: release", ""), "run", "event", None),
        (RISES_AND_FALLS, STEPPED, "run", "commanded_pressure", None),
        (1e-5 * np.sin(40 * TIME), RELEASED, "run", "markers", "0.01 mm"),
        (FALLS, STEPPED, "run_30kPa", "event", "step"),
    ],
)
def test_recordings_that_show_no_motion(recording, displacement, description, name, field, value):
    with refused(field, value):
        measured_motion(recording(displacement, description, name))


def test_a_pose_of_the_tip_is_told_how_it_is_read(recording):
    config = replace(recording(FALLS).config, markers=None, poses={"tip": PoseConfig(["x"] * 3, ["w"] * 4)})
    with pytest.raises(InputError, match="write points that are fixed to its body"):
        measured_motion(replace(recording(FALLS), config=config))


@pytest.mark.parametrize(("later", "is_refused"), [(10e3, False), (9e3, False), (14e3, True), (np.nan, False)])
def test_a_pressure_that_changes_while_the_valve_is_open_is_refused(recording, later, is_refused):
    """A tenth of it may be lost; while it rises, it may be anything."""
    pressures = 10e3 * ((TIME > OPENS) & (TIME < CLOSES))
    pressures[(TIME > 0.9) & (TIME < CLOSES)] = later
    stepped = replace(recording(RISES_AND_FALLS, STEPPED, "10kPa"), pressures=pressures[:, None])
    if is_refused:
        with pytest.raises(InputError, match=r"one constant pressure is read.*a file for each"):
            measured_motion(stepped)
    else:
        assert measured_motion(stepped).pressure == 10e3


def test_a_column_of_pressures_does_not_name_the_pressure(recording):
    stepped = replace(recording(RISES_AND_FALLS, STEPPED, "run"), pressures=np.zeros((len(TIME), 1)))
    with pytest.raises(InputError, match="a column is not read instead"):
        measured_motion(stepped)
    with pytest.raises(InputError, match="one constant pressure in a file"):
        measured_motion(replace(stepped, config=replace(stepped.config, event=None)))
