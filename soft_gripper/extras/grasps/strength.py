"""Standard shake test: the load, N or N m, in each direction, that takes an object out of a grasp.

The scenario runs until the object is held: to its end or, with a task, to the end of the first phase that holds it.
Then everything but the gripper is taken away from the object, which hangs in the grasp for REST. From this state on, a
force at its centre of mass, or a torque, grows from zero along one axis until the object is lost: it has slid along the
fingers by `slid`, turned in them by `turned`, or is touched by none. Six forces and six torques, along both
signs of the axes of B of the first finger, each from the same state, make up the grasp strength.

The strength is the largest load that the contacts resist, as a mean over SMOOTH, in addition to the weight. It
leaves out what accelerates the object once it slides, and so hardly depends on how fast the load grows.
"""

import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.common.value import Value
from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet, Role
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ContactResults, ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import ApplySimulatorConfig, InitializeParams, Simulator
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.cached import get_or_make
from soft_gripper.diagrams.scene import first_body
from soft_gripper.diagrams.simulation import advance, cached_station, run_to_end, solver_config
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.grip_point import Grip, grip_at, shift
from soft_gripper.extras.sweeps.study import results
from soft_gripper.pictures.style import STYLE
from soft_gripper.scenario.scenario_file import dump_scenario, parse_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.contact import TOUCH, patches

REST = 1.0  # s, in which an object hangs in the grasp before it is loaded
PERIOD = 0.01  # s, in which the load is constant
SMOOTH = 5  # periods over which the resisted load is averaged
MAX_LOAD = 10.0  # of a force, in sums of the normal forces; of a torque, these times their mean lever
MIN_LEVER = 5e-3  # m
AXES = ("x", "y", "z")
SLID, TURNED, LET_GO, NOT_LOST, NOT_HELD = "slid", "turned", "let go", "not lost", "not held"
_TEXT_NAME = Path("scenario.yaml")  # name for the text of a scenario in messages


@dataclass(frozen=True)
class Shake:
    """Speed of a load, and limits beyond which the object counts as lost."""

    slid: float = 5e-3  # m along the fingers
    turned: float = math.radians(20)  # relative to the links that touch it
    seconds: float = 2.0  # in which a force grows to the sum of the normal forces

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 < value < math.inf:
                raise InputError("grasp strength", name, value, "give a number above 0")


@dataclass(frozen=True)
class StrengthRow:
    """The strength of a grasp in one direction.

    load: "force" or "torque"; a force acts at the centre of mass.
    direction: along or about an axis of frame B of the first finger: x points in its closing direction, z
        along it to its tip.
    strength: largest load resisted, N or mN m.
    ended: "slid", "turned" or "let go"; "not lost" if the load ended before, "not held" if there was no grasp.
    stiffness: half of the strength over the motion of the object under it, N/mm or mN m/degree.
    moved_mm, turned_deg: motion of the object relative to the palm under the largest load.
    """

    load: str
    direction: str
    strength: Annotated[float, ".3f"]
    unit: str
    ended: str
    stiffness: Annotated[float, ".2f"]
    moved_mm: Annotated[float, ".1f"]
    turned_deg: Annotated[float, ".1f"]


class Load(NamedTuple):
    """One of twelve directions."""

    is_torque: bool
    axis: int
    sign: int

    @property
    def name(self) -> str:
        return f"{'+-'[self.sign < 0]}{AXES[self.axis]}"


LOADS = tuple(Load(is_torque, axis, sign) for is_torque in (False, True) for axis in range(3) for sign in (1, -1))


def grasp_strength(
    scenario: Scenario,
    executor: Executor,
    held: str | None = None,
    shake: Shake | None = None,
    report: Callable[[], Any] = lambda: None,
) -> list[StrengthRow]:
    """Measures the strength of a grasp in twelve directions.

    Args:
        scenario: that grasps an object.
        executor: makes the loads, one a call.
        held: name of the object; None: that of the task, or the first free model.
        shake: limits and speed.
        report: called after each load.

    Raises:
        InputError: if there is no such object.
        SimulationDivergedError: if a simulation diverges.
    """
    held = held_object(scenario, held)
    text = dump_scenario(shortened_scenario(scenario))
    jobs = {load: (text, held, number, shake or Shake()) for number, load in enumerate(LOADS)}
    return list(results(executor, direction_strength, jobs, lambda load: report()).values())


def held_object(scenario: Scenario, name: str | None) -> str:
    """Name of the grasped model under test.

    Raises:
        InputError: if there is none.
    """
    free_names = [model.name for model in scenario.models if model.free]
    if name is None and not free_names:
        raise InputError("grasp strength", "free models", 0, "must be 1 or more; or name the object by --object")
    if name is not None and name not in (names := [model.name for model in scenario.models]):
        raise InputError("grasp strength", "--object", name, f"no such model; known: {', '.join(names)}")
    task = scenario.task
    return name or (task.object if task is not None and task.object in free_names else None) or free_names[0]


def shortened_scenario(scenario: Scenario) -> Scenario:
    """The scenario up to the end of the first task phase that holds an object, or all of it without such a phase."""
    if scenario.task is None:
        return scenario
    holding_phases = [number for number, phase in enumerate(scenario.task.phases) if phase.holds]
    phases = scenario.task.phases[: holding_phases[0] + 1] if holding_phases else scenario.task.phases
    return replace(scenario, task=replace(scenario.task, phases=phases))


def direction_strength(text: str, object_name: str, number: int, shake: Shake) -> StrengthRow:
    """Measures the strength in one direction, in a worker that caches the state before all loads."""

    def settle() -> SettledGrasp:
        return SettledGrasp.from_scenario(parse_scenario(_TEXT_NAME, text), object_name)

    return get_or_make(_settled_grasps, (text, object_name), settle, 1).strength(LOADS[number], shake)


_settled_grasps: "OrderedDict[tuple[str, str], SettledGrasp]" = OrderedDict()


class LoadSample(NamedTuple):
    """The object under a load."""

    resisted: float  # N or N m, by the contacts
    moved: float  # m, in the palm
    turned: float  # rad, in the palm
    lost: str  # empty: it is held


@dataclass(frozen=True, eq=False)
class SettledGrasp:
    """A grasp that holds an object at rest: the state before every load."""

    station: Station
    body: RigidBody
    context: Context

    @classmethod
    def from_scenario(cls, scenario: Scenario, object_name: str) -> "SettledGrasp":
        """Runs a scenario, takes everything but the gripper away from the object, and lets it rest."""
        station = cached_station(scenario)
        if object_name in station.parts.deformables:
            raise InputError(
                "grasp strength", "--object", object_name, "is soft; give a rigid object, which a load moves whole"
            )
        body = first_body(station.plant, object_name)
        context = run_to_end(station).get_context().Clone()
        _remove_supports(station, body, context)
        simulator = _resume(station, context)
        advance(simulator, station, context.get_time() + REST)
        return cls(station, body, context.Clone())

    def strength(self, load: Load, shake: Shake) -> StrengthRow:
        """Measures the strength in one direction."""
        grasp = _HeldBody(self.station, self.body, self.context.Clone(), load, shake)
        unit = "mN m" if load.is_torque else "N"
        kind = "torque" if load.is_torque else "force"
        if not grasp.grips:
            return StrengthRow(kind, load.name, 0.0, unit, NOT_HELD, *[np.nan] * 3)
        samples = list(grasp.ramp())
        return _row(kind, load.name, unit, samples)


def _row(kind: str, direction: str, unit: str, samples: Sequence[LoadSample]) -> StrengthRow:
    """The row of a load, from all its samples."""
    resistance = smoothed(np.array([sample.resisted for sample in samples]))
    distances, angles = (np.array([getattr(sample, name) for sample in samples]) for name in ("moved", "turned"))
    strongest_row = int(np.argmax(resistance))
    half_row = int(np.argmax(resistance >= resistance[strongest_row] / 2))
    scale, motions = (1e3, np.degrees(angles)) if kind == "torque" else (1.0, 1e3 * distances)
    strength = scale * float(resistance[strongest_row])
    stiffness = scale * float(resistance[half_row]) / float(motions[half_row]) if motions[half_row] > 0 else np.inf
    largest_motions = 1e3 * float(distances[strongest_row]), float(np.degrees(angles[strongest_row]))
    return StrengthRow(kind, direction, strength, unit, samples[-1].lost or NOT_LOST, stiffness, *largest_motions)


def smoothed(values: Array) -> Array:
    """Moving means over the last SMOOTH values, (K,); fewer at the beginning."""
    sums = np.cumsum(np.concatenate([np.zeros(1), values]))
    begins = np.maximum(np.arange(1, len(sums)) - SMOOTH, 0)
    return (sums[1:] - sums[begins]) / (np.arange(1, len(sums)) - begins)


class _HeldBody:
    """An object in a grasp, with a load that grows."""

    def __init__(self, station: Station, body: RigidBody, context: Context, load: Load, shake: Shake):
        self._station = station
        self._body = body
        self._load = load
        self._shake = shake
        self._plant = station.plant
        self._simulator = _resume(station, context)
        self._context = station.plant.GetMyMutableContextFromRoot(context)
        self._fingers = {
            geometry.get_value(): finger
            for finger in station.fingers
            for link in finger.links
            for geometry in station.plant.GetCollisionGeometriesForBody(link)
        }
        self._own = {geometry.get_value() for geometry in station.plant.GetCollisionGeometriesForBody(body)}
        self._base = station.fingers[0].base
        self._axis = self._base.EvalPoseInWorld(self._context).rotation().col(load.axis) * load.sign
        self._wrench, centers = self._contact()
        self._normal = sum(force for _, force in centers.values())
        p_WC = [center for center, _ in centers.values()]
        X_WO = body.EvalPoseInWorld(self._context)
        self.grips: list[Grip] = [
            grip_at(self._context, finger, X_WO, center) for finger, (center, _) in centers.items()
        ]
        self._poses = [self._relative_pose(grip.link) for grip in self.grips]
        self._begin = self._relative_pose(self._base)
        arms = [float(np.linalg.norm(center - self._center())) for center in p_WC]
        self._lever = max(float(np.mean(arms)), MIN_LEVER) if arms else MIN_LEVER

    def ramp(self) -> Iterator[LoadSample]:
        """Samples under a growing load, until the object is lost or the load has reached its limit."""
        begin = self._simulator.get_context().get_time()
        scale = self._normal * (self._lever if self._load.is_torque else 1.0)
        for count in range(1, round(MAX_LOAD * self._shake.seconds / PERIOD) + 1):
            load = scale * count * PERIOD / self._shake.seconds
            self._apply(load)
            advance(self._simulator, self._station, begin + count * PERIOD)
            sample = self._sample()
            yield sample
            if sample.lost:
                return

    def _apply(self, load: float) -> None:
        force = ExternallyAppliedSpatialForce()
        force.body_index = self._body.index()
        force.p_BoBq_B = self._body.default_com()
        vector = load * self._axis
        zeros = np.zeros(3)
        force.F_Bq_W = SpatialForce(*((vector, zeros) if self._load.is_torque else (zeros, vector)))
        self._plant.get_applied_spatial_force_input_port().FixValue(self._context, Value([force]))

    def _sample(self) -> LoadSample:
        wrench, centers = self._contact()
        resistance = -float((wrench - self._wrench)[0 if self._load.is_torque else 1] @ self._axis)
        X_PO = self._relative_pose(self._base)
        distance = float(np.linalg.norm(X_PO.translation() - self._begin.translation()))
        return LoadSample(resistance, distance, _angle(self._begin, X_PO), self._loss(centers))

    def _loss(self, centers: dict[Any, tuple[Array, float]]) -> str:
        if sum(force for _, force in centers.values()) < TOUCH:
            return LET_GO
        X_WO = self._body.EvalPoseInWorld(self._context)
        if np.mean([np.linalg.norm(shift(self._context, grip, X_WO)) for grip in self.grips]) > self._shake.slid:
            return SLID
        angles = [_angle(X, self._relative_pose(grip.link)) for X, grip in zip(self._poses, self.grips, strict=True)]
        return TURNED if min(angles) > self._shake.turned else ""

    def _contact(self) -> tuple[Array, dict[Any, tuple[Array, float]]]:
        """Torque about the centre of mass and force of all contacts on the object, (2, 3) N m and N in the world.

        Also the centre of pressure, (3,) m, and the normal force, N, of every finger that touches it.
        """
        results: ContactResults = self._plant.get_contact_results_output_port().Eval(self._context)
        center = self._center()
        wrench = np.zeros((2, 3))
        finger_patches: dict[Any, list[tuple[Array, float]]] = {}
        for patch in patches(results, self._own):
            sign = 1.0 if patch.geometries[0] in self._own else -1.0
            other_geometry = patch.geometries[1 if sign > 0 else 0]
            lever = patch.place - center
            wrench += sign * np.array([patch.torque + np.cross(lever, patch.force), patch.force])
            if other_geometry in self._fingers:
                normal = patch.normal / np.linalg.norm(patch.normal)
                pressing = abs(float(patch.force @ normal))
                finger_patches.setdefault(self._fingers[other_geometry], []).append((patch.place, pressing))
        return wrench, {finger: _mean_center(finger_centers) for finger, finger_centers in finger_patches.items()}

    def _center(self) -> Array:
        return self._body.EvalPoseInWorld(self._context) @ self._body.default_com()

    def _relative_pose(self, body: RigidBody) -> RigidTransform:
        return self._body.body_frame().CalcPose(self._context, body.body_frame())


def _mean_center(finger_patches: Sequence[tuple[Array, float]]) -> tuple[Array, float]:
    """Centre of pressure and sum of the normal forces of several patches."""
    total = sum(force for _, force in finger_patches)
    weights = [force / total if total > 0 else 1 / len(finger_patches) for _, force in finger_patches]
    return np.sum([weight * place for weight, (place, _) in zip(weights, finger_patches, strict=True)], axis=0), total


def _angle(first: RigidTransform, second: RigidTransform) -> float:
    """Angle of the rotation between two poses, rad."""
    return abs(float((first.rotation().inverse() @ second.rotation()).ToAngleAxis().angle()))


def _resume(station: Station, context: Context) -> Simulator:
    """Makes a simulator that continues from a context, without the events of a beginning."""
    simulator = Simulator(station.diagram, context)
    ApplySimulatorConfig(solver_config(station.scenario), simulator)
    simulator.Initialize(InitializeParams(suppress_initialization_events=True))
    return simulator


def _remove_supports(station: Station, body: RigidBody, context: Context) -> None:
    """Lets an object pass through everything but the gripper, in one context."""
    plant = station.plant
    scene_graph = station.parts.scene_graph
    gripper = {link.index() for finger in station.fingers for link in finger.links}
    for finger in station.fingers:
        if not finger.is_anchored:  # otherwise the table is welded to them too
            gripper |= {welded.index() for welded in plant.GetBodiesWeldedTo(finger.base)}
    skins = set(plant.GetCollisionGeometriesForBody(body))
    supports: list[GeometryId] = []
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        owner = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        if geometry not in skins and owner.index() not in gripper:
            supports.append(geometry)
    manager = scene_graph.collision_filter_manager(scene_graph.GetMyMutableContextFromRoot(context))
    manager.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(list(skins)), GeometrySet(supports)))


def strength_figure(rows: Sequence[StrengthRow], title: str) -> Figure:
    """Plots the strength in every direction: forces and torques, a bar for either sign of each axis."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 3.2), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left")
        for axes, kind in zip(figure.subplots(1, 2), ("force", "torque"), strict=True):
            _draw(axes, [row for row in rows if row.load == kind], kind)
    return figure


def _draw(axes: Axes, rows: Sequence[StrengthRow], kind: str) -> None:
    for row in rows:
        sign = 1 if row.direction[0] == "+" else -1
        row_index = AXES.index(row.direction[1])
        color = "#2166ac" if row.ended != NOT_LOST else "#9ecae1"
        axes.barh(row_index, sign * row.strength, color=color, height=0.6)
        text = f"{row.strength:.3g}" if row.ended != NOT_LOST else f"> {row.strength:.3g}"
        axes.annotate(
            text,
            (sign * row.strength, row_index),
            (4 * sign, 0),
            textcoords="offset points",
            ha="left" if sign > 0 else "right",
            va="center",
            fontsize=8,
        )
    verb = "along" if kind == "force" else "about"
    axes.axvline(0, color="0.3", lw=0.8)
    names = [f"{verb} x (closing)", f"{verb} y (sideways)", f"{verb} z (finger)"]
    axes.set(yticks=range(3), yticklabels=names, xlabel=f"{kind} [{rows[0].unit}]")
    axes.invert_yaxis()
    axes.margins(x=0.22)
    axes.grid(axis="x", alpha=0.3)
