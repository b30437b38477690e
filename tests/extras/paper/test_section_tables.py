"""Tables of poses and forces of steps that are held."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.section_tables import force_table, pose_table
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.runs.scores.poses import PoseRow, held_samples, recorded_pose_table
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["pressure.steps.all=[-40e3, 200e3]", "pressure.settle=0.1", "pressure.hold_samples=10"]
ERRORS = {"pose_error_mm": "pose_error", "tip_error_mm": "fingertip_error"}
Bent = Callable[[list[float]], list[PoseRow]]


def short_station(sections: int) -> Station:
    return make_station(load_scenario("free_bending", [*SHORT, f"sensor.sections={sections}"]))


@pytest.fixture(scope="module")
def station() -> Station:
    """Free bending in two short steps, sensed by four sensors per side."""
    return short_station(4)


@pytest.fixture(scope="module")
def recording(station: Station) -> Recording:
    """What a run of the station leaves behind: the finger is still moving while samples are averaged."""
    return run_station(station)


@pytest.fixture
def bent(station: Station) -> Bent:
    """Rows of one sensor per side, from a recording that holds the bend angles of its samples in turn."""

    def table(degrees: list[float]) -> list[PoseRow]:
        samples = round(station.scenario.duration / station.scenario.sensor.period) + 1
        time = np.arange(samples) * station.scenario.sensor.period
        angles = np.radians(np.resize(degrees, samples))
        variables = {}
        for finger in station.fingers:
            q = np.outer(angles, np.full(finger.finger.segments, 1 / finger.finger.segments))
            variables[f"{finger.name}.sampled_joint_angles"] = (["time", f"{finger.name}.joint"], q)
            chain = forward_kinematics(q, finger.finger.segment_length)
            joints, tip = in_space(chain.joints), in_space(chain.tip)
            variables[f"{finger.name}.true_joint_positions"] = (["time", f"{finger.name}.joint", "xyz"], joints)
            variables[f"{finger.name}.true_tip_position"] = (["time", "xyz"], tip)
            variables[f"{finger.name}.sampled_pressure"] = (["time"], np.zeros(samples))
            variables[f"{finger.name}.X_WB"] = (["time", "row", "column"], np.tile(np.eye(3, 4), (samples, 1, 1)))
        return pose_table("bent", station, Recording(xr.Dataset(variables, {"time": time})), [1])

    return table


def test_a_row_for_every_finger_number_of_sections_and_step(station: Station, recording: Recording) -> None:
    rows = pose_table("free", station, recording, [1, 3])
    assert [(r.scenario, r.finger, r.estimator, r.nominal, r.sections, r.pressure_kpa) for r in rows] == [
        ("free", finger, "arcs", "as simulated", sections, pressure)
        for finger in ("left_finger", "right_finger")
        for sections in (1, 3)
        for pressure in (-40.0, 200.0)
    ]


@pytest.mark.parametrize("sections", [1, 4])
def test_agrees_with_the_blocks_of_a_run_with_as_many_sensors(
    station: Station, recording: Recording, sections: int
) -> None:
    rows = pose_table("free", station, recording, [sections])
    other = short_station(sections)
    run = run_station(other)
    for column, signal in ERRORS.items():
        for finger in ("left_finger", "right_finger"):
            by_table = [getattr(row, column) for row in rows if row.finger == finger]
            by_blocks = held_samples(other.scenario, run, f"{finger}.{signal}").reshape(2, -1).mean(axis=1)
            np.testing.assert_allclose(by_table, 1e3 * by_blocks, rtol=1e-9)


@pytest.mark.parametrize("kind", ["arcs", "spline", "gaussian", "contact"])
def test_each_estimator_agrees_with_a_run_with_it(station: Station, recording: Recording, kind: str) -> None:
    other = make_station(load_scenario("free_bending", [*SHORT, f"estimator.type={kind}"]))
    expected = recorded_pose_table("free", other, run_station(other))
    rows = pose_table("free", station, recording, [4], [kind])
    assert [(row.estimator, row.finger) for row in rows] == [(row.estimator, row.finger) for row in expected]
    for column in ERRORS:
        found, run = ([getattr(row, column) for row in table] for table in (rows, expected))
        np.testing.assert_allclose(found, run, rtol=1e-6, atol=1e-9)


def test_errors_are_averaged_not_shapes(bent: Bent) -> None:
    """A finger that flips between two mirrored bends errs as in the mean of both, though on average it is straight.

    The two errors differ: the outer sensors lie farther from the neutral axis than the inner ones.
    """
    inward, outward, both_ways = (bent(degrees)[0] for degrees in ([90.0], [-90.0], [90.0, -90.0]))
    assert both_ways.bend_angle_deg == pytest.approx(0, abs=1e-9)
    for error in ERRORS:
        one_way, other_way = getattr(inward, error), getattr(outward, error)
        assert getattr(both_ways, error) == pytest.approx((one_way + other_way) / 2)
        assert min(one_way, other_way) > 0.01


STEPS = ["pressure.steps.all=[60e3, 120e3, -30e3]", "pressure.hold_samples=10"]
FINGERS = ("left_finger", "right_finger")


def recorded(name, *overrides):
    station = make_station(load_scenario(name, [*STEPS, *overrides]))
    return station, run_station(station)


def column(rows, name, *shape):
    """Of the first finger."""
    return np.array([getattr(row, name) for row in rows if row.finger == FINGERS[0]]).reshape(shape)


@pytest.fixture(scope="module")
def obstructed():
    """The obstructed finger, the first of two, with four sensors per side, and its recording."""
    return recorded("obstructed_inside")


@pytest.mark.slow
@pytest.mark.parametrize("sections", [4, 2])
def test_holds_what_the_blocks_put_out(obstructed, sections):
    """For the sensors of the run itself, and for others by a run with those."""
    rows = force_table("obstructed", *obstructed, [sections])
    station, recording = obstructed if sections == 4 else recorded("obstructed_inside", f"sensor.sections={sections}")
    for name, signal in (("estimated_nm", "external_torque"), ("true_nm", "true_external_torque")):
        by_blocks = held_samples(station.scenario, recording, f"{FINGERS[0]}.{signal}").mean(axis=1)
        np.testing.assert_allclose(column(rows, name, 3, 12), by_blocks, atol=1e-6)
        assert np.abs(by_blocks).max() > 0.05


def test_a_row_for_every_finger_number_of_sections_step_and_joint():
    rows = force_table("free", *recorded("free_bending", "pressure.settle=0.01"), [1, 3])
    assert [(r.scenario, r.finger, r.estimator, r.nominal, r.sections, r.pressure_kpa, r.joint) for r in rows] == [
        ("free", finger, "arcs", "as simulated", sections, pressure, joint)
        for finger in FINGERS
        for sections in (1, 3)
        for pressure in (60.0, 120.0, -30.0)
        for joint in range(12)
    ]
