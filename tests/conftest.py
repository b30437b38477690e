"""What the tests share: a finger, its sensors, and plants that pydrake alone loads."""

import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.sensors.sensor_layout import SensorLayout

LoadPlant = Callable[..., MultibodyPlant]


@pytest.fixture(autouse=True)
def _forget_own_modules(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A user's module that a test has written and imported is not that of the next test, which may name it alike."""
    before, written = set(sys.modules), str(tmp_path_factory.getbasetemp())
    yield
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", None)).startswith(written):
            del sys.modules[name]


@pytest.fixture(scope="session")
def shipped_finger() -> Finger:
    """The finger of models/grippers/finger.urdf."""
    (finger,) = expand_urdf(DIRECTORY / "grippers/finger.urdf").fingers
    return finger


@pytest.fixture(scope="session")
def tapered_finger(shipped_finger: Finger) -> Finger:
    """A finger of another name, with few segments, of which every quantity changes along its length."""
    tip = replace(
        shipped_finger.base,
        width=0.012,
        thickness=0.011,
        youngs_modulus=3e5,
        density=900.0,
        chamber_width=5e-3,
        chamber_thickness=6e-3,
        chamber_center=-5e-4,
        layer_thickness=1e-4,
        layer_modulus=3e8,
    )
    return replace(shipped_finger, name="tapered", tip=tip, segments=5, sensor_spacing=0.01)


@pytest.fixture(params=[(1, False), (2, False), (4, False), (5, False), (3, True)], ids=str)
def layout(request: pytest.FixtureRequest, shipped_finger: Finger) -> SensorLayout:
    """Sensors on the shipped finger: (sections, one_sided)."""
    return SensorLayout(shipped_finger, *request.param)


@pytest.fixture(scope="session")
def load_plant() -> LoadPlant:
    """Loads URDF text with pydrake and nothing of ours; welds the link `base`, if named, to the world."""

    def load(text: str, base: str = "", time_step: float = 0.0) -> MultibodyPlant:
        plant = MultibodyPlant(time_step)
        Parser(plant).AddModelsFromString(text, "urdf")
        if base:
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(base))
        plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
        if time_step > 0:
            plant.SetUseSampledOutputPorts(False)
        plant.Finalize()
        return plant

    return load


@pytest.fixture(scope="session")
def finger_plant(load_plant: LoadPlant) -> LoadPlant:
    """A plant, without gravity, of one finger whose frame B is the world frame."""

    def build(finger: Finger, time_step: float = 0.0) -> MultibodyPlant:
        robot = ET.Element("robot", name="robot")
        robot.extend(finger_to_urdf(FingerElement(finger, "world")))
        return load_plant(ET.tostring(robot, encoding="unicode"), time_step=time_step)

    return build


@pytest.fixture(scope="session")
def drake_weight(finger_plant: LoadPlant) -> Callable[..., Array]:
    """Drake's torques of a finger's weight, by joint angles, rad, and gravity in B, (3,) m/s^2."""

    def evaluate(finger: Finger, q: Array, gravity: Sequence[float]) -> Array:
        plant = finger_plant(finger)
        plant.mutable_gravity_field().set_gravity_vector(gravity)
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, q)
        return plant.CalcGravityGeneralizedForces(context)

    return evaluate


@pytest.fixture(scope="session")
def bent() -> Callable[..., Array]:
    """Random joint angles, `bent(*shape)`, rad: up to 0.4 either way, the same in every run."""
    return lambda *shape: np.random.default_rng(1).uniform(-0.4, 0.4, shape)
