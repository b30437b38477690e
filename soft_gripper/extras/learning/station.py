"""make_learning_station: an environment -> a diagram with the ports `action` and `observation`, built once.

Observation: signals of the estimation -> what an agent observes.

`OBSERVABLE` lists the signals that an agent may observe, so that a file cannot request ground truth.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import DepthRange, DepthRenderCamera, Meshcat, Role
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)
from pydrake.systems.primitives import AffineSystem, ConstantVectorSource
from pydrake.systems.sensors import RgbdSensor
from scipy.linalg import expm

from soft_gripper.arrays import Array
from soft_gripper.diagrams.private_run import remove_unread_blocks
from soft_gripper.diagrams.scene import arm_joints, first_body
from soft_gripper.diagrams.station import add_station
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.view.meshcat_view import box_corners
from soft_gripper.errors import InputError
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.learning.config import ActionConfig, EnvironmentConfig, ObservedConfig
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.pictures.rendering import DIRECTION, framing_camera, make_renderer
from soft_gripper.scenario.schema import Scenario
from soft_gripper.signals import describe
from soft_gripper.truth.contact import patches


def action_ranges(config: ActionConfig) -> Array:
    """Set points for action entries of -1 and 1, (n, 2) Pa, m or rad."""
    return np.array([config.range, *config.joints.values()])


def resting_action(config: ActionConfig, home: Mapping[str, float]) -> Array:
    """The action with which an episode begins, (n): the grip's rest and the joints' home, by their names."""
    low, high = action_ranges(config).T
    begin = np.array([config.rest, *(home[name] for name in config.joints)])
    return np.clip(2 * (begin - low) / (high - low) - 1, -1, 1)


def add_action(
    builder: DiagramBuilder,
    config: ActionConfig,
    grips: Sequence[InputPort],
    desired: InputPort | None,
    home: Mapping[str, float],
    period: float,
) -> None:
    """Exports the input `action` (n), and adds `action.grip` and, with joints, `action.joints`.

    ::

        action (n) ---> action.grip ----> pressure of every finger, Pa, or opening, m
               +------> action.joints --> desired state of the arm, positions and velocities (2 m)

    Args:
        builder: of the diagram.
        config: meaning of an action.
        grips: inputs for the pressures or the opening.
        desired: input for the desired state of the arm, if there is one.
        home: initial positions of the joints of the arm, by name, in the order of the arm; those that no
            action moves stay there.
        period: of the samples at which joints are commanded, s.

    Raises:
        InputError: if a joint does not belong to the arm.
    """
    low, high = action_ranges(config).T
    gain = np.diag((high - low) / 2)
    grip = AffineSystem(D=gain[:1], y0=(low + high)[:1] / 2)
    builder.AddNamedSystem("action.grip", grip)
    builder.ExportInput(grip.get_input_port(), "action")
    for port in grips:
        builder.Connect(grip.get_output_port(), port)
    if desired is not None:
        rows = _joint_rows(config, list(home))
        mean_positions = rows @ (low + high) / 2
        motion = _joint_motion(rows @ gain, mean_positions, np.array([*home.values()]), config.settling, period)
        builder.AddNamedSystem("action.joints", motion)
        builder.ConnectInput("action", motion.get_input_port())
        builder.Connect(motion.get_output_port(), desired)


def _joint_rows(config: ActionConfig, joints: list[str]) -> Array:
    """Matrix (m, n) with 1 where an action entry moves a joint of the arm, else 0."""
    rows = np.zeros((len(joints), 1 + len(config.joints)))
    for i, name in enumerate(config.joints, 1):
        if name not in joints:
            raise InputError("action", "joints", name, f"the arm has: {', '.join(joints)}")
        rows[joints.index(name), i] = 1.0
    return rows


def _joint_motion(gain: Array, middle: Array, home: Array, time: float, period: float) -> AffineSystem:
    """Critically damped motion of each joint q to its set point r, of time constant T, exact at the samples:

    T^2 q'' = r - q - 2 T q'. It begins at rest at home. A joint that no action moves has its home as set point.

    Args:
        gain: from the action to the set points, (m, n).
        middle: set points at an action of 0, (m).
        home: (m).
        time: T, s.
        period: of the samples, s.
    """
    count = len(home)
    middle = np.where(gain.any(axis=1), middle, home)
    rate_matrix = np.array([[0.0, 1.0, 0.0], [-1 / time**2, -2 / time, 1 / time**2], [0.0, 0.0, 0.0]])
    transition = np.kron(expm(rate_matrix * period)[:2], np.eye(count))
    A, to_set_point = transition[:, : 2 * count], transition[:, 2 * count :]
    begin = np.concatenate([home, np.zeros(count)])
    return AffineSystem(
        A=A, B=to_set_point @ gain, f0=to_set_point @ (middle - home), C=np.eye(2 * count), y0=begin, time_period=period
    )


MAX_OBSERVED = 10.0  # largest observed value
# Measured, estimated or commanded signals; all others are ground truth.
OBSERVABLE = (
    *("strain", "extension_ratio", "sampled_pressure", "theta", "kappa", "arcs", "estimated_joint_angles"),
    *("joint_positions", "tip_pose", "free_bending_angles", "driving_torque", "external_torque", "position_std"),
    *("contact", "contact_force", "contact_arc_length", "contact_force_std"),
    *(
        "transverse_force",
        "transverse_force_std",
        "pressure_command",
        "desired_state",
        "opening",
        "torque",
        "force",
        "object_width",
        "set_point",
        "target",
        "goal",
    ),
)


def scaled(values: Array, scales: Array) -> Array:
    """Values divided by their scales, (..., n), and limited to the observed range; 0 where unknown."""
    finite_values = np.nan_to_num(values / scales, nan=0.0, posinf=MAX_OBSERVED, neginf=-MAX_OBSERVED)
    return np.clip(finite_values, -MAX_OBSERVED, MAX_OBSERVED)


class Observation(LeafSystem):
    """Puts chosen entries of signals into one vector, each divided by its scale.

    ::

        {signal} ---> +-------------+ ---> observation (n) 1
                      | Observation |
                      +-------------+
    """

    def __init__(self, configs: Sequence[ObservedConfig], sizes: Mapping[str, int]):
        """`sizes` of the signals, by their names."""
        super().__init__()
        names = list(dict.fromkeys(config.signal for config in configs))
        starts = dict(zip(names, np.cumsum([0, *(sizes[name] for name in names)]), strict=False))
        entries = [config.entries or range(sizes[config.signal]) for config in configs]
        self._entries = np.concatenate([starts[config.signal] + k for config, k in zip(configs, entries, strict=True)])
        self._scales = np.repeat([config.scale for config in configs], [len(indices) for indices in entries])
        self._ports = [self.DeclareVectorInputPort(name, sizes[name]) for name in names]
        self.DeclareVectorOutputPort("observation", len(self._entries), self._calc)

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.observe(*(port.Eval(context) for port in self._ports)))

    def observe(self, *signals: Array) -> Array:
        """The observation, (..., n), from the signals, (..., size) each."""
        return scaled(np.concatenate(signals, axis=-1)[..., self._entries], self._scales)


def add_observation(
    builder: DiagramBuilder, configs: Sequence[ObservedConfig], signals: Mapping[str, OutputPort]
) -> OutputPort:
    """Adds `observation`; returns its output.

    Raises:
        InputError: if a signal does not exist, has no such entry, or is not observable.
    """
    for i, config in enumerate(configs):
        field, name = f"observation[{i}]", config.signal
        if name.rpartition(".")[2] not in OBSERVABLE:
            raise InputError(
                field, "signal", name, f"is not an estimate; an agent may observe: {', '.join(OBSERVABLE)}"
            )
        if name not in signals:
            raise InputError(field, "signal", name, f"no such signal; known: {', '.join(sorted(signals))}")
        size = signals[name].size()
        if not all(0 <= entry < size for entry in config.entries):
            raise InputError(field, "entries", config.entries, f"give some of 0 to {size - 1}")
    block = Observation(configs, {config.signal: signals[config.signal].size() for config in configs})
    builder.AddNamedSystem("observation", block)
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        builder.Connect(signals[port.get_name()], port)
    return block.get_output_port()


FORCE_PERIOD = 0.02  # s; forces through a finger take several times as long to rise and fall


def normal_forces(results: ContactResults, finger_of: Mapping[int, int], fingers: int) -> Array:
    """Force on each finger along the normals of its contacts with other bodies, (fingers) N."""
    forces = np.zeros(fingers)
    for patch in patches(results, finger_of):
        first, second = map(finger_of.get, patch.geometries)
        force = abs(patch.force @ patch.normal) / math.hypot(*patch.normal)
        for finger in (first, second):
            if finger is not None and first != second:
                forces[finger] += force
    return forces


class PeakForce(LeafSystem):
    """Samples the contact forces every FORCE_PERIOD.

    ::

        contact_results ---> +-----------+ ---> force (F) N, of each finger, now
                             | PeakForce | ---> peak  (F) N, the largest sample since the beginning
                             +-----------+
    """

    def __init__(self, finger_of: Mapping[int, int], fingers: int):
        """`finger_of` is the finger of each geometry, by the value of its GeometryId."""
        super().__init__()
        self._finger_of, self._fingers = dict(finger_of), fingers
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self.DeclareVectorOutputPort("force", fingers, self._calc, {self._results.ticket()})
        self.DeclareStateOutputPort("peak", self.DeclareDiscreteState(fingers))
        self.DeclarePeriodicDiscreteUpdateEvent(FORCE_PERIOD, 0.0, self._update)

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._now(context))

    def _update(self, context: Context, values: DiscreteValues) -> None:
        values.set_value(np.maximum(context.get_discrete_state_vector().value(), self._now(context)))

    def _now(self, context: Context) -> Array:
        return normal_forces(self._results.Eval(context), self._finger_of, self._fingers)


def add_peak_force(builder: DiagramBuilder, station: StationParts) -> PeakForce:
    """Adds `peak_force` for the fingers of a station."""
    plant = station.plant
    finger_of = {
        geometry.get_value(): number
        for number, finger in enumerate(station.fingers)
        for link in finger.links
        for geometry in plant.GetCollisionGeometriesForBody(link)
    }
    block = PeakForce(finger_of, len(station.fingers))
    builder.AddNamedSystem("peak_force", block)
    builder.Connect(plant.get_contact_results_output_port(), block.get_input_port())
    return block


_PRESSURE_COUNT = 64  # of the table from which the tip is interpolated


class TipTarget(LeafSystem):
    """Target of the tip: its position of rest under a sinusoidal pressure.

    ::

        +-----------+ ---> target (2) x, z in B, m
        | TipTarget |
        +-----------+

    The mean and the amplitude of the pressure, Pa, the period, s, and the phase, rad, are parameters in the context.
    """

    def __init__(self, finger: Finger, gravity: complex, limits: tuple[float, float]):
        """`gravity` in the bending plane, m/s^2; `limits` of the pressure, Pa."""
        super().__init__()
        self._pressures = np.linspace(*limits, _PRESSURE_COUNT)
        q = resting_angles(finger, self._pressures, np.full(_PRESSURE_COUNT, gravity))
        self._tips: Array = as_points(forward_kinematics(q, finger.segment_length).tip)  # (_PRESSURE_COUNT, 2) m
        self._swing = self.DeclareNumericParameter(BasicVector([sum(limits) / 2, 0.0, 1.0, 0.0]))
        tickets = {self.time_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("target", 2, self._calc, tickets)

    def swing(self, context: Context, mean: float, amplitude: float, period: float, phase: float) -> None:
        """Sets the motion in the context of the block."""
        context.get_mutable_numeric_parameter(self._swing).SetFromVector([mean, amplitude, period, phase])

    def _calc(self, context: Context, output: BasicVector) -> None:
        mean, amplitude, period, phase = context.get_numeric_parameter(self._swing).value()
        pressure = mean + amplitude * np.sin(2 * np.pi * context.get_time() / period + phase)
        output.SetFromVector([np.interp(pressure, self._pressures, column) for column in self._tips.T])


PICTURE_HEIGHT, PICTURE_WIDTH = 360, 480  # pixels of a picture
_RENDERER_NAME = "learning"
_LIFT_MARGIN = np.array([0.0, 0.0, 0.1])  # m, room in the picture above moving bodies


@dataclass(frozen=True)
class LearningStation:
    """A station that an agent acts on."""

    diagram: Diagram
    parts: StationParts
    forces: PeakForce | None  # on the fingers, if they handle an object
    is_seen: bool  # by a camera or in Meshcat
    object: RigidBody | None = None  # first body of the handled object
    object_height: float = 0.0  # m, of its frame over its lowest point
    target: TipTarget | None = None
    goal: ConstantVectorSource | None = None

    def follow(self, context: Context, task_draw: Array) -> None:
        """Sets the random part of a task, if it has one, in a context of the diagram, see `Task.draw`."""
        if self.target is not None:
            self.target.swing(self.target.GetMyMutableContextFromRoot(context), *task_draw)
        if self.goal is not None:
            self.goal.get_mutable_source_value(self.goal.GetMyMutableContextFromRoot(context)).SetFromVector(task_draw)


def make_learning_station(
    config: EnvironmentConfig,
    scenario: Scenario,
    picture: bool = False,
    meshcat: Meshcat | None = None,
    composed: bool = True,
) -> LearningStation:
    """Builds a diagram.

    ::

        action (n) ---> +---------+ ---> observation (k)
                        | station | ---> picture, if requested
                        +---------+

    Args:
        config: of the environment.
        scenario: of this station; the commands that an action gives are left open.
        picture: whether a camera looks at the scene.
        meshcat: shows the scene and the estimates.
        composed: see `add_station`.

    Raises:
        InputError: if a part cannot be built, or does not match the others.
    """
    builder, is_seen = DiagramBuilder(), picture or meshcat is not None
    parts = add_station(builder, scenario, meshcat, visuals=is_seen, composed=composed)
    inputs = dict(parts.inputs)
    desired = None if parts.arm is None else inputs.pop(f"{parts.arm.name}.desired_state", None)
    add_action(builder, config.action, [*inputs.values()], desired, home(parts), parts.plant.time_step())
    object_task = config.grasp or config.pick_place
    forces = None if object_task is None else add_peak_force(builder, parts)
    target = goal = None
    task_signals: dict[str, OutputPort] = {}
    if config.reach is not None:
        finger, (low, high) = parts.fingers[0], config.reach.pressure  # one that stands still
        gravity = planar_gravity(finger.X_WB.GetAsMatrix34(), np.array(scenario.gravity))
        target = builder.AddNamedSystem("target", TipTarget(finger.finger, complex(gravity), (low, high)))
        task_signals["target"] = target.get_output_port()
    if config.pick_place is not None:
        goal = builder.AddNamedSystem("goal", ConstantVectorSource([config.pick_place.goal[0]]))
        task_signals["goal"] = describe(goal.get_output_port(), "m")
    observation = add_observation(builder, config.observation, parts.signals | task_signals)
    builder.ExportOutput(observation, "observation")
    if picture:
        builder.ExportOutput(_add_camera(builder, parts), "picture")
    parts.signals = remove_unread_blocks(builder, parts.signals).signals
    diagram = builder.Build()
    parts.check(diagram)
    if object_task is None:
        return LearningStation(diagram, parts, forces, is_seen, target=target)
    if object_task.object in parts.deformables:
        raise InputError("environment", "object", object_task.object, "is soft; give a rigid object")
    body = first_body(parts.plant, object_task.object)
    return LearningStation(diagram, parts, forces, is_seen, body, _height(parts, body), goal=goal)


def home(parts: StationParts) -> dict[str, float]:
    """Initial positions of the joints of the arm, by name; none without an arm."""
    if parts.arm is None:
        return {}
    names = [joint.name() for joint in arm_joints(parts.plant, parts.arm.model)]
    return dict(zip(names, map(float, parts.arm.home), strict=True))


def _height(parts: StationParts, body: RigidBody) -> float:
    """Height of the frame of a body over its lowest point at the start, m."""
    plant, context = parts.plant, parts.plant.CreateDefaultContext()
    corners = box_corners(plant, parts.scene_graph, context, [body.model_instance()], Role.kProximity)
    return float(body.EvalPoseInWorld(context).translation()[2] - corners[:, 2].min())


def _add_camera(builder: DiagramBuilder, station: StationParts) -> OutputPort:
    """Adds `camera`, which sees the fingers and the objects; returns its picture."""
    station.scene_graph.AddRenderer(_RENDERER_NAME, make_renderer())
    camera = framing_camera(_visible_corners(station), PICTURE_HEIGHT, PICTURE_WIDTH, DIRECTION)
    color = camera.render_camera(_RENDERER_NAME, 1)
    depth = DepthRenderCamera(color.core(), DepthRange(0.05, 5.0))  # RgbdSensor requires one, which is not used
    sensor = RgbdSensor(station.scene_graph.world_frame_id(), camera.X_WC, color, depth)
    builder.AddNamedSystem("camera", sensor)
    builder.Connect(station.scene_graph.get_query_output_port(), sensor.query_object_input_port())
    return sensor.color_image_output_port()


def _visible_corners(station: StationParts) -> Array:
    """Corners of all bodies in the picture, (M, 3) m: fingers and free objects, at the start and lifted."""
    plant, context = station.plant, station.plant.CreateDefaultContext()
    models = {finger.model for finger in station.fingers}
    models |= {plant.GetModelInstanceByName(model.name) for model in station.scenario.models if model.free}
    corners = box_corners(plant, station.scene_graph, context, models, Role.kPerception)
    return np.concatenate([corners, corners + _LIFT_MARGIN])
