"""The sensors of a finger in a diagram: what they read, a user's own, and what cannot be a sensor."""

import numpy as np
import pytest
from own_blocks import WARMTH, WarmSensor
from pydrake.systems.framework import LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from soft_gripper.diagrams.simulation import make_simulator, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import pose_entries
from soft_gripper.scenario.scenario_file import load_scenario

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
