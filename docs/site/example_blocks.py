"""One system of every block of the project: those of a few stations, and those that no station has."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Diagram, System

import soft_gripper as sg
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.calibration_range import CalibrationRange
from soft_gripper.estimators.finger_shape import FingerShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.bench.bench import Bench, HeldInput
from soft_gripper.extras.hardware.replay.arm_estimation import ArmEstimation, LogSource, NominalArm, RigidParts
from soft_gripper.extras.hardware.replay.wire_lengths import WireGeometry
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.link_sensors import CurvatureSensors

_SCENARIOS = {
    "pick_and_place_delicate": ["estimator.alongside=[arcs, gaussian]", "sensor.pressure_errors={noise: 20}"],
    "pick_and_place_box": [],
    "pick_and_place_sponge": [],
    "arm_motion": ["external=[tool]", "task=null"],
    "tip_distance_steps": ["estimator.health=true", "pressure.leaks={left_finger: 0.1}"],
    "three_chambers": [],
    "tendon_grasp": [],
    "turned_box_grasp": [
        *("estimator.type=gaussian", "estimator.alongside=[recursive]"),
        "sensor.layout=four_faces_and_diagonal",
    ],
}
_FORCE_LIMITED = ["control.force_limit=0.5", "control.force_gains.ki=1.0", "estimator.type=contact"]
_CREEPING = "package://soft_gripper/recordings/pneumatic_segment.urdf"
_LAW = 'pressure="0 45000" effective="0 45000"', 'pressure="0 2e4 4e4" effective="0 2e4 5e4" stiffness_taken="0 .1 .1"'


@dataclass(frozen=True)
class Placed:
    """A system, and the diagram that it is in, if it is in one."""

    system: System
    diagrams: tuple[Diagram, ...] = field(default=())  # from the outermost


@cache
def example_blocks() -> dict[type, Placed]:
    """The first system found of every class of the project."""
    found: dict[type, Placed] = {}
    for placed in _all_systems():
        of = type(placed.system)
        if of.__module__.startswith("soft_gripper."):
            found.setdefault(of, placed)
    return found


@cache
def station(name: str) -> Station:
    """A shipped scenario, built; kept, since Drake does not free it."""
    meshcat = Meshcat() if name in ("pick_and_place_delicate", "pick_and_place_sponge") else None
    return sg.make_station(sg.load_scenario(name, _SCENARIOS.get(name, [])), meshcat)


def _all_systems() -> Iterator[Placed]:
    for name in _SCENARIOS:
        yield from _inside(Placed(station(name).diagram))
    yield from _inside(Placed(_creeping_finger().diagram))
    yield from _inside(Placed(make_private_station(sg.load_scenario("tip_distance_steps")).diagram))
    yield from _inside(Placed(Bench(sg.load_scenario("tip_distance_steps")).diagram))
    yield Placed(HeldInput(0.01, 8, "1"))
    finger = station("tip_distance_steps").fingers[0].finger
    yield Placed(FingerShape(finger))
    yield Placed(sg.sensors.SensorBlock(CurvatureSensors(finger, 2), 0.01))
    states = CalibratedStates(FittedStates(np.zeros((1, 11)), np.ones(11)), Widths(np.zeros(1), 0.0), 1.0, sections=4)
    yield Placed(CalibrationRange(sg.sensors.SensorLayout(finger, 4), states, np.zeros(3)))
    yield from _inside(Placed(sg.make_station(sg.load_scenario("tip_distance_steps", _FORCE_LIMITED)).diagram))
    yield from _inside(Placed(_arm_estimation()))
    yield Placed(LogSource("strain", np.zeros((2, 8)), 0.01, "1", path=("inner", "outer"), section=range(4)))


def _inside(placed: Placed) -> Iterator[Placed]:
    """A system and, of a diagram, all that is in it."""
    yield placed
    if isinstance(placed.system, Diagram):
        for system in placed.system.GetSystems():
            yield from _inside(Placed(system, (*placed.diagrams, placed.system)))


def _creeping_finger() -> Station:
    """The station of a finger that creeps, and whose chamber widens and takes a part of its stiffness."""
    text = sg.model_path(_CREEPING).read_text(encoding="utf-8")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "segment.urdf"
        file.write_text(text.replace(*_LAW), encoding="utf-8")
        return sg.make_station(sg.Scenario(models=[sg.ModelConfig(name="segment", file=str(file))]))


def _arm_estimation() -> ArmEstimation:
    """The estimation of an arm of two sections and two chambers, straight, with ideal wires."""
    finger = station("tip_distance_steps").fingers[0].finger
    zeros = np.zeros(2)
    arm = NominalArm(
        finger=finger,
        gains=np.zeros((finger.segments, 2)),
        rest=np.zeros(finger.segments),
        wires=WireGeometry(finger.sensor_spacing, zeros, zeros, zeros, zeros),
        parts=RigidParts(0j, 0.0, zeros.astype(complex), zeros.astype(complex), zeros),
        uncertainty=Uncertainty(),
        gravity=np.array([0.0, 0.0, -9.81]),
    )
    return ArmEstimation(arm, "gaussian", 2, ["middle", "end"], 0.01)
