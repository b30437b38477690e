"""Contact forces of a recording: true and estimated, with a band that holds the truth, printed without nan."""

import numpy as np
import pytest
import xarray as xr
from refusals import refused

from soft_gripper.diagrams.contact_forces import force_band
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.estimators.force_posterior import HERE, MOVING, NOTHING
from soft_gripper.runs.scores.contact_forces import contact_rows, estimator_of_forces
from soft_gripper.scenario.scenario_file import load_scenario

NAN = np.nan
STEPS = ["pressure.steps={all: [0.0, 75.0e3]}", "pressure.settle=0.5", "pressure.hold_samples=50"]


@pytest.mark.parametrize(
    ("interval", "answer", "expected"),
    [
        ((0.4, 0.5, 0.7), HERE, (0.4, 0.7)),
        ((0.1, 0.2, 1.5), NOTHING, (0.0, 1.5)),  # the interval is given contact
        ((NAN, NAN, NAN), NOTHING, (NAN, NAN)),
        ((NAN, NAN, NAN), MOVING, (NAN, NAN)),
    ],
)
def test_the_band_begins_at_0_where_no_contact_is_detected(interval, answer, expected):
    found = force_band(np.array([interval]), np.array([answer]))
    np.testing.assert_array_equal([each[0] for each in found], expected)


@pytest.fixture(scope="module", params=["contact", "arcs"])
def grasp(request):
    station = make_private_station(load_scenario("box_grasp", [f"estimator.type={request.param}", *STEPS]))
    return station, simulate(station.scenario)


def test_the_band_of_a_grasp_holds_the_true_force_of_the_recording(grasp):
    station, recording = grasp
    rows = contact_rows(station, recording)
    assert [(row.finger, round(row.time_s, 6)) for row in rows] == [
        (finger, time) for time in (1.0, 2.0) for finger in ("left_finger", "right_finger")
    ]
    for row in rows[2:]:
        names = "true_transverse_force", "true_contact_force", "normal_force"
        transverse, across, pressing = (recording[f"{row.finger}.{name}"].values[-1] for name in names)
        assert (row.true_transverse_n, row.true_normal_n) == (transverse, across)
        assert row.true_transverse_n == pytest.approx(pressing, rel=0.1)
        assert 0.5 < row.least_n < row.true_transverse_n < row.most_n < 1.2
        assert row.transverse_n == pytest.approx(row.true_transverse_n, rel=0.03)
        assert row.closing_n == pytest.approx(row.true_closing_n, rel=0.05)
        assert row.true_mm == pytest.approx(row.estimated_mm, abs=3)


def test_contact_estimates_what_it_would_have_during_the_run(grasp):
    """With `arcs` in the run, `contact` reads what was recorded: the same forces as with `contact` in the run."""
    station, recording = grasp
    assert estimator_of_forces(station, recording) == "contact"
    with_contact = simulate(load_scenario("box_grasp", ["estimator.type=contact", *STEPS])).forces()
    for row in contact_rows(station, recording)[2:]:
        found = next(each for each in with_contact.at(row.time_s) if each.finger == row.finger)
        assert (row.transverse_n, row.least_n, row.most_n, row.normal_n) == pytest.approx(
            (found.transverse_n, found.least_n, found.most_n, found.normal_n), rel=1e-6
        )


def test_forces_over_time_are_the_signals(grasp):
    _, recording = grasp
    data = recording.forces().data
    assert dict(data.sizes) == {"time": recording.data.sizes["time"], "finger": 2}
    right = data.sel(finger="right_finger")
    np.testing.assert_array_equal(right["true_transverse"], recording["right_finger.true_transverse_force"])
    assert data["true_transverse"].attrs["units"] == "N"
    assert data["location"].attrs["units"] == "m"
    if "right_finger.contact_force" in recording.data:
        np.testing.assert_array_equal(right["transverse"], recording["right_finger.transverse_force"])
        np.testing.assert_array_equal(right["normal"], recording["right_finger.contact_force"])
    else:
        assert np.isnan(right["transverse"]).all()
        assert "not known" in str(recording.forces())


def test_the_last_sample_is_printed_and_others_can_be_asked_for(grasp):
    _, recording = grasp
    forces = recording.forces()
    assert str(forces).startswith("Transverse contact forces at 2.00 s\n")
    assert [row.time_s for row in forces.at(1.004)] == [1.0, 1.0]
    for time in (-0.1, 2.1, NAN):
        with refused("time", time):
            forces.at(time)


def test_a_recording_without_contact_forces_is_refused():
    with refused("signal", "true_transverse_force or transverse_force"):
        Recording(xr.Dataset({"finger.strain": ("time", [0.0])}, {"time": [0.0]})).forces()
