"""Fingers that touch themselves: links that are further apart than neighbours stay apart, and nothing else changes."""

import numpy as np
import pytest
from pydrake.geometry import QueryObject, Role
from refusals import refused

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

PRESSURE = 650e3  # Pa, by which a finger curls up by 408 degrees


def curled(is_on, pressure=PRESSURE):
    models = [f"models.{side}_finger.self_contact={is_on}" for side in ("left", "right")]
    steps = ["gravity=[0, 0, 0]", "pressure.maximum=1e6", f"pressure.steps.all=[{pressure}]"]
    short = ["pressure.settle=7.9", "pressure.hold_samples=10"]
    station = make_station(load_scenario("free_bending", [*steps, *short, *models]))
    return station, run_station(station)


@pytest.fixture(scope="module")
def touching():
    return curled(True)


def overlaps(station, state):
    """How far each pair of links of the first finger overlaps at a state of the plant, m, (N + 1, N + 1)."""
    finger, plant = station.fingers[0], station.plant
    context = station.diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.SetPositionsAndVelocities(own, state)
    query = plant.get_geometry_query_input_port().Eval(own)
    assert isinstance(query, QueryObject)
    inspector = query.inspector()
    skins = [
        inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(link.index()), Role.kProximity) for link in finger.links
    ]
    found = np.zeros((len(skins), len(skins)))
    for i, j in zip(*np.triu_indices(len(skins), 3), strict=True):
        found[i, j] = -query.ComputeSignedDistancePairClosestPoints(skins[i][0], skins[j][0]).distance
    return found


def at_rest(run, signal):
    return run[1][f"left_finger.{signal}"].values[-1]


@pytest.mark.slow
def test_a_curled_finger_lies_on_itself(touching):
    """Half as deep in itself as without contact: as far as its skin yields."""
    off = curled(False)
    deep, shallow = (overlaps(touching[0], run[1]["plant.state"].values[-1]) for run in (off, touching))
    assert deep.max() > 5e-3
    assert shallow.max() < 0.5 * deep.max()
    assert np.degrees(at_rest(off, "sampled_joint_angles").sum()) > 400
    assert np.degrees(at_rest(touching, "sampled_joint_angles").sum()) < 390


@pytest.mark.slow
def test_its_links_push_each_other_and_nothing_else(touching):
    """At rest the springs bear pressure and self contact, and no force comes from outside."""
    finger, torque = touching[0].fingers[0].finger, at_rest(touching, "true_external_torque")
    balance = finger.pressure_torque(PRESSURE) + torque
    assert np.abs(torque).max() > 0.05
    np.testing.assert_allclose(finger.stiffness * at_rest(touching, "sampled_joint_angles"), balance, rtol=1e-3)
    assert touching[1]["left_finger.true_contact_total"].values.max() == 0.0


@pytest.mark.slow
def test_neighbours_do_not_touch():
    """At half a turn links up to two apart overlap on the inner side, and bear nothing."""
    on, off = curled(True, 300e3), curled(False, 300e3)
    np.testing.assert_array_equal(on[1]["plant.state"].values, off[1]["plant.state"].values)
    assert np.degrees(at_rest(on, "sampled_joint_angles").sum()) > 180


@pytest.mark.slow
@pytest.mark.parametrize(("pressure", "touches"), [(570e3, False), (580e3, True)])
def test_the_shipped_finger_first_touches_itself_at_a_full_turn(pressure, touches):
    run = curled(True, pressure)
    assert np.degrees(at_rest(run, "sampled_joint_angles").sum()) == pytest.approx(360, abs=3)
    assert at_rest(run, "true_external_torque").any() == touches


@pytest.mark.parametrize(
    ("changes", "value"),
    [
        (["models.left_finger.self_contact=true", "contact=points"], True),
        (
            ["models.left_finger.self_contact=true", "models.left_finger.file=package://soft_gripper/objects/box.sdf"],
            True,
        ),
    ],
    ids=["points", "no finger"],
)
def test_what_cannot_touch_itself(changes, value):
    with refused("self_contact", value):
        make_station(load_scenario("free_bending", changes))
