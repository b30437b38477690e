"""Sensors, and what is made of their readings in a station."""

from importlib import import_module

import numpy as np
import pytest
from own_blocks import WARMTH, WarmSensor
from pydrake.systems.framework import LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from soft_gripper.diagrams.simulation import make_simulator, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring import estimation, scoring
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import pose_entries
from soft_gripper.estimators.uncertainty import uncertainty_of
from soft_gripper.fingers.finger_links import joint_name, link_name
from soft_gripper.load.contact_detector import ContactDetector
from soft_gripper.load.force_estimator import ForceEstimator
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.truth.contact import TrueContact

ONE_FINGER, TWO_FINGERS, THREE_FINGERS = "one finger", "box_grasp", "three_finger_grasp"
LONELY = "{name: finger, file: package://soft_gripper/grippers/finger.urdf}"
SCENARIOS = (ONE_FINGER, THREE_FINGERS)


def station(name, threshold, *overrides):
    """Of a shipped scenario, or of a single finger, which none of them has."""
    changes = [f"estimator.contact_threshold={threshold}", *overrides]
    if name == ONE_FINGER:
        name, changes = "free_bending", [f"models=[{LONELY}]", *changes]
    return make_station(load_scenario(name, changes))


def test_truth_looks_at_all_shapes_of_every_finger_and_at_no_others(monkeypatch):
    """Oracle: what moves with the first joint of a finger, and its base."""
    seen, held = {}, {}

    def spy(fingers, interval, objects):
        seen.update(fingers)
        held.update(objects)
        return TrueContact(fingers, interval, objects)

    monkeypatch.setattr(scoring, "TrueContact", spy)
    plant = station(TWO_FINGERS, 2.5e-3).plant
    assert set(seen) == {"left_finger", "right_finger"}
    (box,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("box"))
    assert held == {"box": [box.get_value()]}
    for finger, links in seen.items():
        moved = plant.GetBodiesKinematicallyAffectedBy([plant.GetJointByName(joint_name(finger, 0)).index()])
        bodies = [plant.GetBodyByName(link_name(finger, 0)), *(plant.get_body(index) for index in moved)]
        expected = [shape for body in bodies for shape in plant.GetCollisionGeometriesForBody(body)]
        assert len(bodies) == 13
        assert len(expected) >= 13
        assert links.link_of.keys() == {shape.get_value() for shape in expected}
        assert [plant.get_body(index).name() for index in links.bodies] == [link_name(finger, i) for i in range(13)]


@pytest.mark.parametrize("name", SCENARIOS)
def test_blocks_are_made_for_what_the_scenario_says(monkeypatch, name):
    """Of 12 joints 4 lie in the first of three sections; the force is estimated of the nominal finger."""
    detectors, forces = [], []

    def detector(*arguments):
        detectors.append(arguments)
        return ContactDetector(*arguments)

    def force_estimator(finger, gravity, period, *_):
        forces.append((finger.name, finger.length, gravity.tolist(), period))
        return ForceEstimator(finger, gravity, period)

    monkeypatch.setattr(estimation, "ContactDetector", detector)
    monkeypatch.setattr(estimation, "ForceEstimator", force_estimator)
    overrides = ("sensor.sections=3", "sensor.period=0.02", "gravity=[1, 2, -3]", "nominal.finger.length=+5 %")
    fingers = station(name, 3e-3, *overrides).fingers
    assert detectors == [(12, 4, 0.02, 3e-3)] * len(fingers)
    nominal = [(finger.name, pytest.approx(1.05 * finger.finger.length), [1, 2, -3], 0.02) for finger in fingers]
    assert forces == nominal


@pytest.mark.parametrize("given", [None, 5e-5])
def test_estimators_know_of_the_errors_of_the_sensors_unless_a_scenario_says_otherwise(monkeypatch, given):
    """Those beside the estimator of the scenario too."""
    known = []
    for name in ("estimation", "scoring"):
        module = import_module(f"soft_gripper.diagrams.wiring.{name}")
        find = module.find_estimator
        monkeypatch.setattr(
            module,
            "find_estimator",
            lambda kind, u, *field, find=find: known.append((kind, u.reading)) or find(kind, u),
        )
    changes = ["sensor.errors.noise=0.003", "estimator.type=gaussian", "estimator.alongside=[spline]"]
    changes += [] if given is None else [f"estimator.uncertainty.reading={given}"]
    make_station(load_scenario("obstructed_inside", changes))
    expected = given or uncertainty_of(StrainErrors(noise=0.003)).reading
    assert set(known) == {("gaussian", expected), ("spline", expected)}


SHORT = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.1", "pressure.hold_samples=5"]


def short(name="free_bending", *overrides):
    return load_scenario(name, [*SHORT, *overrides])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["free_bending", "pick_and_place_box"])
def test_the_pose_of_the_base_is_known_at_once(name):
    """Where it stands still, for ever; under an arm it is sampled, first before the plant's first step."""
    station = make_station(short(name))
    simulator = make_simulator(station)
    simulator.Initialize()
    plant_context = station.plant.GetMyContextFromRoot(simulator.get_context())

    def poses():
        return [pose_entries(station.plant.EvalBodyPoseInWorld(plant_context, f.base)) for f in station.fingers]

    begin = poses()
    for time in (0.0, 0.355):
        simulator.AdvanceTo(time)
        for finger, expected in zip(station.fingers, poses() if time else begin, strict=True):
            found = station.diagram.GetOutputPort(f"{finger.name}.X_WB").Eval(simulator.get_context())
            moved = np.abs(found - expected).max()
            assert moved < (0.02 if name == "pick_and_place_box" and time else 1e-12)


def warm(**options):
    return run_station(make_station(short("free_bending", *options.pop("overrides", [])), **options))


@pytest.mark.parametrize(
    "options",
    [{"make_sensor": WarmSensor}, {"overrides": ["sensor.type=own_blocks:warm_sensor"]}],
    ids=["call", "name"],
)
def test_a_sensor_of_the_users_takes_the_place_of_ours(options):
    """What it puts out besides is recorded, with its unit; all else is as it was."""
    own, ours = warm(**options), warm()
    warmth = own["left_finger.warmth"]
    assert warmth.attrs["units"] == "K"
    np.testing.assert_allclose(warmth[1:], WARMTH * own["left_finger.pressure"][:-1], rtol=1e-12)
    assert "left_finger.extension_ratio" not in own.data
    for signal in ("strain", "theta", "external_torque", "pose_error"):
        np.testing.assert_array_equal(own[f"left_finger.{signal}"], ours[f"left_finger.{signal}"])


class Curious(LeafSystem):
    """Asks for what there is not."""

    def __init__(self, name, size):
        super().__init__()
        self.DeclareVectorInputPort(name, size)


@pytest.mark.parametrize(
    ("sensor", "complaint"),
    [
        (
            lambda: Curious("temperature", 1),
            "sensor: input port = 'temperature': a sensor may take: joint_angles, pressure, X_WB",
        ),
        (lambda: Curious("joint_angles", 3), "sensor: input port 'joint_angles' = 3: "),
        (lambda: ConstantVectorSource([0.0]), "sensor: output ports = 'y0, sampled_pressure': a sensor outputs its"),
    ],
)
def test_what_is_no_sensor(sensor, complaint):
    with pytest.raises(InputError) as caught:
        make_station(short(), make_sensor=lambda layout, period: sensor())
    assert complaint in str(caught.value)
