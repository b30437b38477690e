"""The whole schema of a scenario file, on one page. SI units; every field has its explanation and range next to it.

A field that may be left out, and then means that there is no such thing, is None. `violations` are rules across the
fields of a class; those across the parts of a scenario are in `checks.py`.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

from pydrake.common.schema import Transform
from pydrake.common.yaml import yaml_load_file
from pydrake.multibody.parsing import ModelDirective
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlantConfig
from pydrake.systems.analysis import GetIntegrationSchemes, SimulatorConfig
from pydrake.visualization import VisualizationConfig

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.files.document import dotted_changes
from soft_gripper.files.number import is_number
from soft_gripper.fingers.finger_links import SPRINGS
from soft_gripper.quantity import Rule, Violation, like, quantity, valid
from soft_gripper.registry import registered, with_added_fields
from soft_gripper.scenario.drake_values import ByValue
from soft_gripper.scenario.finger_changes import FINGER_PATHS, MODEL_PATHS
from soft_gripper.scenario.shipped import PRESETS
from soft_gripper.sensors.path_sensors import LAYOUTS, STEEPEST
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import SENSOR_FAULTS, StrainErrors

ATMOSPHERE = 101325.0  # Pa; no vacuum is deeper


@dataclass
@with_added_fields
class MeshConfig:
    """Properties of a model that is a bare mesh file; its inertia follows from its shape and the model's mass."""

    scale: float = quantity(1.0, "m", above=0)  # length unit of the file: 0.001 for millimetres
    color: list[float] = quantity([0.45, 0.62, 0.36, 1.0], least=0, most=1, length=4)  # red, green, blue, opacity


@dataclass(eq=False)
class ModelConfig(ByValue):
    """A model and its pose."""

    name: str = quantity("", is_name=True)  # a model with a single finger passes its name on to the finger
    # package:// URI or path relative to the scenario file; a URDF may hold <finger>s
    file: str = quantity("", filled=True)
    parent: str = "world"  # frame to which it is welded: "world" or "model::frame"
    child: str | None = None  # frame of the model that is welded; None: its first link
    X_PC: Transform = field(default_factory=Transform)  # child frame in the parent frame
    free: bool = False  # not welded: X_PC is the initial pose of its first link in the world
    # Of all its links, whose inertias change in proportion; None: as in the file, 0.05 kg for a bare mesh.
    mass: float | None = quantity(None, "kg", above=0)
    # Coulomb, equal static and dynamic, of all its shapes; None: as in the file, 0.8 for a bare mesh.
    friction: float | None = quantity(None, least=0)
    # By name of a joint; those left out are as in the file. An arm has `arm.home` instead.
    initial_position: dict[str, list[float]] = quantity({}, "rad or m")
    without: list[str] = field(default_factory=list)  # links of its file to omit, with everything attached to them
    segments: int | None = quantity(None, least=1)  # of every finger in the file; None: as in the file
    springs: str | None = quantity(None, known=SPRINGS)  # see docs/finger.md; None: linear ones if they are stable
    # Changes of its <finger>s, by name or for "all": numbers or "+10 %", by the path of a field of `Finger`, as in
    # `contact.friction`; `width` by itself, or another field of a section, is that of every section.
    fingers: dict[str, dict[str, str]] = quantity({}, paths=MODEL_PATHS)
    self_contact: bool = False  # whether links of a finger that are more than two apart touch each other
    half_space: bool = False  # its box, such as a table, is all that lies below its upper face, see docs/solver.md
    mesh: MeshConfig = field(default_factory=MeshConfig)  # for a file that is a bare mesh (.obj, .stl, .ply ...)

    def __post_init__(self) -> None:
        if isinstance(self.fingers, dict):
            self.fingers = {name: dotted_changes(changes, MODEL_PATHS) for name, changes in self.fingers.items()}

    def violations(self) -> Iterator[Violation]:
        if self.free and (self.parent != "world" or self.child is not None):
            yield "free", True, "leave parent and child out: a free model is not welded"
        if self.free and self.half_space:
            yield "half_space", True, "leave it out: a free model has an end"


@dataclass
class PressureConfig:
    """The pressure supply, and the pressure steps used if nothing else commands the pressure."""

    steps: dict[str, list[float]] = quantity({"all": [0.0]}, "Pa", filled=True)  # by "finger::chamber", finger or "all"
    settle: float = quantity(1.0, "s", least=0)  # before the averaged samples of a step
    hold_samples: int = quantity(100, least=1)  # sensor samples averaged in each step
    minimum: float = quantity(-50e3, "Pa", least=-ATMOSPHERE)  # of the supply; negative: vacuum
    maximum: float = quantity(210e3, "Pa")  # of the supply
    time_constant: float = quantity(0.05, "s", least=0)  # first-order lag between command and chamber; 0: no lag
    # By finger or "all": share of the measured pressure that does not reach the chambers, from leak_time on.
    leaks: dict[str, float] = quantity({}, least=0, most=1)
    leak_time: float = quantity(0.0, "s", least=0)

    def violations(self) -> Iterator[Violation]:
        if self.minimum > self.maximum:
            yield "minimum", self.minimum, f"must be at most the maximum, {self.maximum:g} Pa"
        for finger, steps in self.steps.items():
            for i, step in enumerate(steps):
                if not self.minimum <= step <= self.maximum:
                    limits = f"{self.minimum:g} to {self.maximum:g} Pa"
                    yield f"steps.{finger}[{i}]", step, f"must be within the limits of the supply, {limits}"


@dataclass
class TendonConfig:
    """The winches of fingers with tendons, and the steps used if nothing else commands them."""

    # What is commanded: the "tension", N; or the length that is pulled in at the winch, m: "pull".
    command: str = quantity("tension", known=("tension", "pull"))
    steps: dict[str, list[float]] = quantity({"all": [0.0]}, filled=True)  # by "finger::tendon", finger or "all"
    maximum: float | None = quantity(None, least=0)  # of the winches; None: no limit
    time_constant: float = quantity(0.05, "s", least=0)  # first-order lag between command and winch; 0: no lag

    def violations(self) -> Iterator[Violation]:
        max_tension = math.inf if self.maximum is None else self.maximum
        for name, steps in self.steps.items():
            for i, step in enumerate(steps):
                if not 0 <= step <= max_tension:
                    yield f"steps.{name}[{i}]", step, f"must be from 0 to {max_tension:g}: tendons pull"


@dataclass
class ControlConfig:
    """Closed loop: the gripper opening, controlled through the pressure of all fingers.

    The opening is twice the mean distance of the fingertips from their centroid: of two, their distance.
    """

    # In sequence; None: set by a task or an input, or open loop.
    set_points: list[float] | None = quantity(None, "m", above=0, filled=True)
    hold: float = quantity(4.0, "s", above=0)  # at every set point
    gains: PidGains = field(default_factory=PidGains)  # from the opening error, m, to the pressure, Pa
    torque_limit: float | None = quantity(None, "N m", above=0)  # at the base of the fingers: limit of the grip
    torque_gains: PidGains = field(default_factory=PidGains)  # from the torque error to the pressure, Pa
    # Limit of the estimated mean closing force of the fingers, along -x of their bases, instead of a torque_limit.
    force_limit: float | None = quantity(None, "N", above=0)
    # Limit the mean upper bound of their contact forces instead, while contact is detected; each is exceeded with a
    # probability of 2.5 %.
    force_bound: bool = False
    force_gains: PidGains = field(default_factory=PidGains)  # from the force error to the pressure, Pa

    def violations(self) -> Iterator[Violation]:
        points = self.set_points or []
        for i in range(1, len(points)):
            if points[i] == points[i - 1]:
                yield f"set_points[{i}]", points[i], "is not a step: it must differ from the set point before"
        for kind in ("gains", "torque_gains", "force_gains"):
            for name in ("kp", "ki", "kd"):
                gain = getattr(getattr(self, kind), name)
                if gain < 0:
                    yield f"{kind}.{name}", gain, "must be at least 0"
        for kind in ("torque", "force"):
            gain = getattr(self, f"{kind}_gains").ki
            if getattr(self, f"{kind}_limit") is not None and gain == 0:
                yield f"{kind}_gains.ki", gain, f"must be above 0 to hold the {kind}_limit"
        if self.torque_limit is not None and self.force_limit is not None:
            yield "force_limit", self.force_limit, "leave it out beside a torque_limit"


@dataclass
class JointLimitsConfig:
    """Limits of a joint of an arm that replace those of its file; None: as in the file."""

    lower: float | None = quantity(None, "rad or m")
    upper: float | None = quantity(None, "rad or m")
    velocity: float | None = quantity(None, "rad/s or m/s", above=0)
    effort: float | None = quantity(None, "N m or N", above=0)


@dataclass
class ArmConfig:
    """The arm among the models: the gripper is welded to one of its frames. Joints have implicit PD controllers."""

    model: str = ""  # its name
    # Initial posture; joints in order from the base, without those that follow others (<mimic>).
    home: list[float] = quantity([], "rad or m")
    frequency: float = quantity(10.0, "Hz", above=0)  # natural frequency of a joint under PD control
    damping_ratio: float = quantity(1.0, above=0)  # of a joint under PD control
    # Limit for every joint; velocity and effort are limited by the file of the arm, or by the next field.
    acceleration: float = quantity(10.0, "rad/s^2 or m/s^2", above=0)
    limits: dict[str, JointLimitsConfig] = field(default_factory=dict)  # by name of the joint


@dataclass
class PhaseConfig:
    """A part of a task. The arm moves, or stays if neither `to` nor `posture` is given; then it waits for `until`."""

    name: str = quantity("", is_name=True)
    to: str | None = quantity(None, known=("object", "goal", "home"))  # where the gripper goes
    height: float = quantity(0.0, "m")  # above the grasp or place pose
    posture: list[float] | None = quantity(None, "rad or m")  # alternative to `to`: target posture of the arm
    straight: bool = False  # straight line of the gripper; otherwise straight in joint space
    speed: float = quantity(1.0, above=0, most=1)  # fraction of the arm's velocity limits
    opening: float | None = quantity(None, "m", above=0)  # set point of the gripper from this phase on; None: unchanged
    # Event that ends the phase after the motion; None: the end of `rest`.
    until: str | None = quantity(None, known=("opened", "grasped", "released"))
    rest: float = quantity(0.0, "s", least=0)  # after the motion, without `until`
    holds: bool = False  # the object is held: its loss is a failure

    def violations(self) -> Iterator[Violation]:
        if self.to is not None and self.posture is not None:
            yield "posture", self.posture, f"leave it out beside to: {self.to}"


@dataclass
class PoseErrorConfig:
    """The pose reported by a camera minus the true pose. The height above a known table has no error."""

    x: float = quantity(0.0, "m")  # in the world
    y: float = quantity(0.0, "m")  # in the world
    yaw: float = quantity(0.0, "rad")  # about the vertical through the origin of its first link


@dataclass(eq=False)
@with_added_fields
class TaskConfig(ByValue):
    """The phases of the arm's motion; phases with an opening also command the gripper, in closed loop."""

    object: str | None = None  # name of the free model to handle; only its reported initial pose is known
    X_OG: Transform = field(default_factory=Transform)  # grasp: the gripper's welded frame in the object's first link
    X_WGoal: Transform = field(default_factory=Transform)  # goal pose of the object's first link in the world
    phases: list[PhaseConfig] = quantity([], filled=True)
    grip_threshold: float = quantity(0.02, "N m", above=0)  # torque at the base of the fingers that counts as a grip
    # Range within which the estimated opening of a gripper at rest stays; larger for noisy sensors.
    quiet_band: float = quantity(5e-4, "m", above=0)
    timeout: float = quantity(4.0, "s", above=0)  # maximum wait of a phase for the event that ends it
    time_limit: float = quantity(60.0, "s", above=0)  # for the whole task
    # Normal force of a finger that the object withstands; used to judge trials.
    force_limit: float | None = quantity(None, "N", above=0)
    # Squeeze that an object withstands which gives way; used to judge trials.
    squeeze_limit: float | None = quantity(None, "m", above=0)
    pose_error: PoseErrorConfig = field(default_factory=PoseErrorConfig)  # of the pose that motions are planned for

    @property
    def grips(self) -> bool:
        """Whether the task commands the gripper."""
        return any(phase.opening is not None for phase in self.phases)

    def violations(self) -> Iterator[Violation]:
        for i, phase in enumerate(self.phases):
            asks = "until" if phase.until is not None else "holds" if phase.holds else None
            if asks is not None and not self.grips:
                expected = "the gripper is not commanded: no phase has an opening"
                yield f"phases[{i}].{asks}", getattr(phase, asks), expected
        if self.grips and self.phases[0].opening is None:
            yield "phases[0].opening", None, "must be the opening that the task begins with, m"


@dataclass
class SensorPathConfig:
    """A strain sensor along a path of the finger; a single number holds for the whole path."""

    name: str = quantity("", is_name=True)
    x: list[float] = quantity([0.0], "m", filled=True)  # from the middle of the section, toward the inner side
    y: list[float] = quantity([0.0], "m", filled=True)  # across the finger
    at: list[float] = quantity([0.0, 1.0], least=0, most=1, filled=True)  # stations, as shares of the length
    # Slopes of short strands side by side along the path, dx/ds and dy/ds against it; 1 is 45 degrees.
    x_slope: float = quantity(0.0, least=-STEEPEST, most=STEEPEST)
    y_slope: float = quantity(0.0, least=-STEEPEST, most=STEEPEST)


@dataclass
class DeadSensorConfig:
    """A dead strain sensor."""

    path: str = "outer"  # one of the names of the paths
    section: int = quantity(0, least=0)  # from the base


@cache
def presets() -> dict[str, dict[str, Any]]:
    return yaml_load_file(str(PRESETS))


@dataclass
class StrainErrorsConfig:
    """The errors of the strain sensors, in the order of their action on the extension ratio; docs/sensors.md.

    A field that is None is as in the preset; without a preset there is no such error. Strain is the extension ratio
    minus 1; standard deviations are those of independent draws for every sensor.
    """

    preset: str | None = quantity(None, known=lambda: tuple(presets()))  # kind of sensor, see sensor_presets.yaml
    creep: float | None = like(StrainErrors, "creep")  # delayed fraction of the strain
    creep_time: float | None = like(StrainErrors, "creep_time")  # time constant of the delayed fraction
    hysteresis: float | None = like(StrainErrors, "hysteresis")  # loop width of a cycle, relative to its stroke
    # Standard deviation, drawn once per run, as a fraction of the strain.
    gain_error: float | None = like(StrainErrors, "gain_error")
    offset: float | None = like(StrainErrors, "offset")  # standard deviation, drawn once per run, extension ratio
    # Standard deviation of the drift after one minute at a constant rate, extension ratio.
    drift: float | None = like(StrainErrors, "drift")
    # Standard deviation of a Gauss-Markov process, extension ratio.
    low_frequency_noise: float | None = like(StrainErrors, "low_frequency_noise")
    correlation_time: float | None = like(StrainErrors, "correlation_time")  # of that process
    noise: float | None = like(StrainErrors, "noise")  # standard deviation, white, of every sample, extension ratio
    saturation: list[float] | None = like(StrainErrors, "saturation")  # measuring range, extension ratio
    quantization: float | None = like(StrainErrors, "quantization")  # step of the extension ratio
    delay: int | None = like(StrainErrors, "delay")  # samples
    dropout: float | None = like(StrainErrors, "dropout")  # probability that a sample is lost and reads NaN
    dead: list[DeadSensorConfig] = field(default_factory=list)  # sensors that always read NaN


@dataclass
class SensorFaultConfig:
    """A strain sensor that fails during a run."""

    kind: str = quantity("dead", known=SENSOR_FAULTS)
    finger: str = "all"  # its name, or "all"
    path: str = "outer"  # one of the names of the paths
    section: int = quantity(0, least=0)  # from the base
    time: float = quantity(0.0, "s", least=0)  # of its onset
    # Strain that it adds (offset), reads at most (saturated) or always (dead; None: its last), share of the strain that
    # is lost (loose), strain a second (drifting).
    size: float | None = None

    def violations(self) -> Iterator[Violation]:
        if self.size is None and self.kind != "dead":
            yield "size", None, f"must be given for {self.kind}"
        if self.kind == "loose" and self.size is not None and not 0 < self.size <= 1:
            yield "size", self.size, "must be a share of the strain, above 0 and at most 1"


@dataclass
class SensorConfig:
    """The sensors of every finger."""

    # "strain", "curvature", "orientation", or "module:function", "module:Class" of your own, see
    # scenario/sensor_presets.py.
    type: str = "strain"
    sections: int = quantity(4, least=1)  # sensors in series along each path
    borders: list[float] | None = None  # section boundaries, as fractions of the length; None: equal sections
    period: float = quantity(0.01, "s", above=0)  # between samples, of the sensors and of every log
    # Where strain is measured: on the two "sides" in the bending plane, or on more, see docs/sensors.md.
    layout: str = quantity("sides", known=("sides", *LAYOUTS))
    paths: list[SensorPathConfig] = field(default_factory=list)  # any paths, instead of a layout
    one_sided: bool = False  # of the sides, only the outer path is measured; the inner side is inextensible
    response: list[list[float]] | None = None  # [extension ratio, reading] points; None: the reading is the strain
    errors: StrainErrorsConfig | None = None  # of the strain sensors; None: ideal sensors
    pressure_errors: PressureErrors | None = None  # of the pressure sensor; None: an ideal sensor
    faults: list[SensorFaultConfig] = field(default_factory=list)  # of strain sensors, during a run
    seed: int = quantity(0, least=0)  # of all random numbers of the sensors

    def violations(self) -> Iterator[Violation]:
        if self.paths and self.layout != "sides":
            yield "layout", self.layout, "leave it out: the paths are listed"
        if self.one_sided and (self.paths or self.layout != "sides"):
            yield "one_sided", True, "leave it out: only the layout of two sides has one"


@dataclass
class UncertaintyConfig:
    """Uncertainty that an estimator assumes; see `Uncertainty`.

    A field that is None follows from the errors of the sensors, or has its default.
    """

    reading: float | None = like(Uncertainty, "reading")  # of the measured extension ratios
    angle: float | None = like(Uncertainty, "angle")  # of a joint's angle where the finger differs from the nominal one
    # Fraction of the bend due to pressure and to the memory of creep: how wrong the nominal stiffness and drive may be.
    bend_per_pressure: float | None = like(Uncertainty, "bend_per_pressure")
    bend_variation: float | None = like(Uncertainty, "bend_variation")  # its linear change along the finger
    pressure: float | None = like(Uncertainty, "pressure")  # of the pressure measurement
    gain: float | None = like(Uncertainty, "gain")  # fraction of the strain, per sensor
    offset: float | None = like(Uncertainty, "offset")  # of the extension ratio, per sensor
    drift: float | None = like(Uncertainty, "drift")  # what offsets drift in a minute, over its square root
    creep: float | None = like(Uncertainty, "creep")  # random walk of the bend per pressure
    load_pressure: float | None = like(Uncertainty, "load_pressure")  # that of a usual load at the base
    largest_force: float | None = like(Uncertainty, "largest_force")  # that the scene can exert on a finger
    friction: float | None = like(Uncertainty, "friction")  # largest coefficient between a finger and what it touches
    free_pressure: float | None = like(Uncertainty, "free_pressure")  # below which sensors are zeroed; 0: never
    nearest_contact: float | None = like(Uncertainty, "nearest_contact")  # fraction of the length


@dataclass
@with_added_fields
class EstimatorConfig:
    """The estimators of every finger."""

    type: str = "arcs"  # of the shape, see docs/estimators.md; or your own "module:function"
    alongside: list[str] = field(default_factory=list)  # further types, recorded and scored without affecting the run
    uncertainty: UncertaintyConfig = field(default_factory=UncertaintyConfig)  # of probabilistic estimators
    compensate_gravity: bool = True  # remove the finger's own weight from the force estimate
    # Torque above which contact is detected; None: no contact detection.
    contact_threshold: float | None = quantity(None, "N m", above=0)

    def violations(self) -> Iterator[Violation]:
        if self.contact_threshold is not None and not self.compensate_gravity:
            expected = "leave it true: with the weight of the finger in the torque, contact would always be detected"
            yield "compensate_gravity", False, expected
        for i, kind in enumerate(self.alongside):
            if kind == self.type or self.alongside.count(kind) > 1:
                yield f"alongside[{i}]", kind, "is an estimator of this scenario already"


@dataclass
class NominalConfig:
    """Differences of the nominal model of fingers and sensors from the simulated ones."""

    finger: dict[str, str] = quantity({}, paths=FINGER_PATHS)  # changes of every finger, as in `models.NAME.fingers`
    file: str | None = None  # URDF whose <finger> of the same name, or only one, is assumed; changes come on top
    creep: bool = True  # include the creep of the finger, if it has any
    response: list[list[float]] | None = None  # of the sensors; None: as simulated
    calibration: str | None = None  # file that `soft-gripper calibrate` wrote, applied to the nominal model so far

    def __post_init__(self) -> None:
        self.finger = dotted_changes(self.finger, FINGER_PATHS)


def default_plant_config() -> MultibodyPlantConfig:
    """Discrete steps of 10 ms; a time_step of 0 is continuous. The choice is measured in docs/solver.md."""
    return MultibodyPlantConfig(time_step=0.01, use_sampled_output_ports=False)


def default_simulator_config() -> SimulatorConfig:
    """Settings for a continuous plant; with a discrete plant, nothing is left to integrate."""
    return SimulatorConfig(integration_scheme="cenic", max_step_size=0.02, accuracy=1e-3)


# Those of the installed Drake, such as "lagged" for kLagged.
_CONTACT_APPROXIMATIONS = [name[1:].lower() for name in reversed(DiscreteContactApproximation.__members__)]
# Of what Drake's configs may be given here.
_PLANT_RULES = {
    "time_step": Rule("s", least=0),
    "contact_model": Rule(known=("hydroelastic_with_fallback", "hydroelastic", "point")),
    "discrete_contact_approximation": Rule(known=_CONTACT_APPROXIMATIONS),
    "contact_surface_representation": Rule(known=("polygon", "triangle")),
    "penetration_allowance": Rule("m", above=0),
    "stiction_tolerance": Rule("m/s", above=0),
}
_SOLVER_RULES = {
    "integration_scheme": Rule(known=GetIntegrationSchemes),
    "max_step_size": Rule("s", above=0),
    "accuracy": Rule(least=1e-9),  # below this, error control takes endlessly many steps
    "target_realtime_rate": Rule(least=0),
}
_VISUALIZATION_RULES = {
    "lcm_bus": Rule(known=("default",)),  # LCM is not published to
    "publish_period": Rule("s", above=0),
    "initial_proximity_alpha": Rule(least=0, most=1),
    "mouse_interaction_stiffness": Rule("1/s^2", least=0),
}


@dataclass
class RecordConfig:
    """Ground truth that is computed for the recording."""

    # The ground truth: "all"; "forces", without the patches of contact, which cost the most; "every 10", with the
    # patches at every tenth sample; or "none".
    truth: str = "all"

    @property
    def patches_every(self) -> int | None:
        """Samples from one record of the contact patches to the next; None: they are not recorded."""
        words = self.truth.split()
        return int(words[1]) if words[0] == "every" else 1 if self.truth == "all" else None

    def violations(self) -> Iterator[Violation]:
        if re.fullmatch(r"all|forces|none|every [1-9][0-9]{0,5}", self.truth) is None:
            yield "truth", self.truth, 'must be "all", "forces", "every N" with N samples, or "none"'


DRAKE = "drake"  # the engine that others are compared with


def engines() -> tuple[str, ...]:
    return DRAKE, *registered("ENGINES")


@dataclass(eq=False)
class Scenario(ByValue):
    """A whole scenario: models, drive, sensors, estimators and solver.

    A part that is null, such as `control: null`, has its defaults, as if it were left out.
    """

    description: str = ""
    # Criteria of success, of the measures of a sweep, as "grasp is held" or "slid_mm at most 1". A task that holds an
    # object has further ones.
    success: list[str] = field(default_factory=list)
    # Drake's model directives, added before the models, which can be welded to what they add, see docs/drake_users.md
    directives: list[ModelDirective] = field(default_factory=list)
    models: list[ModelConfig] = quantity([], filled=True)
    gravity: list[float] = quantity([0.0, 0.0, -9.81], "m/s^2", length=3)  # in the world
    pressure: PressureConfig = field(default_factory=PressureConfig)
    tendons: TendonConfig = field(default_factory=TendonConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    arm: ArmConfig | None = None
    task: TaskConfig | None = None
    # Commands that are input ports of the station, for a diagram around it: "pressure" of every finger, or the
    # "opening" of the gripper; and, with an arm, its "joints", or the pose of the "tool".
    external: list[str] = quantity([], known=("pressure", "opening", "joints", "tool"))
    sensor: SensorConfig = field(default_factory=SensorConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    nominal: NominalConfig = field(default_factory=NominalConfig)
    record: RecordConfig = field(default_factory=RecordConfig)
    # Description of hardware for `soft-gripper live`, a file relative to this one; None: `--bench` names it
    bench: str | None = None
    # What simulates the plant; engines other than Drake let fingers touch at points, whatever `contact` says.
    engine: str = quantity(DRAKE, known=engines)
    # The longest step of an engine other than Drake; None: the longest that is short enough for the scenario
    engine_step: float | None = quantity(None, "s", least=1e-5)
    # What Meshcat shows besides the view that is always drawn, and mouse springs; None: nothing
    visualization: VisualizationConfig | None = field(default=None, metadata=valid(parts=_VISUALIZATION_RULES))
    # How fingers touch other bodies: over the surface of their links, or at points of it, which is faster; see
    # docs/solver.md for what that changes.
    contact: str = quantity("surface", known=("surface", "points"))
    contact_points: int = 4  # on either side of a link: 2, 4 or 8
    plant_config: MultibodyPlantConfig = field(default_factory=default_plant_config, metadata=valid(parts=_PLANT_RULES))
    simulator_config: SimulatorConfig = field(
        default_factory=default_simulator_config, metadata=valid(parts=_SOLVER_RULES)
    )

    def violations(self) -> Iterator[Violation]:
        if self.contact_points not in (2, 4, 8):
            yield "contact_points", self.contact_points, "must be 2, 4 or 8"
        for i, text in enumerate(self.success):
            if read_criterion(text) is None:
                yield f"success[{i}]", text, f"must be {FORM}"
        for name in ("publish_illustration", "enable_meshcat_creation"):
            if self.visualization is not None and not getattr(self.visualization, name):
                expected = "must be true: a view shows the bodies, in the Meshcat it is given"
                yield f"visualization.{name}", False, expected

    @property
    def points(self) -> int | None:
        """Points on either side of a link at which fingers touch other bodies; None: their shapes touch."""
        over_surfaces = self.plant_config.contact_model != "point"
        is_by_points = self.contact == "points" or (self.engine != DRAKE and over_surfaces)
        return self.contact_points if is_by_points else None

    @property
    def steps(self) -> int:
        """Number of steps, of pressures and tendons or, in closed loop, of the set point."""
        if self.control.set_points is not None:
            return len(self.control.set_points)
        return max(len(steps) for part in (self.pressure, self.tendons) for steps in part.steps.values())

    @property
    def step_duration(self) -> float:
        """Time between steps, s."""
        if self.control.set_points is not None:
            return self.control.hold
        return self.pressure.settle + self.pressure.hold_samples * self.sensor.period

    @property
    def duration(self) -> float:
        """Duration of the run, s; a task may end earlier."""
        if self.task is not None:
            return self.task.time_limit
        return self.steps * self.step_duration


FORM = "MEASURE at most NUMBER, MEASURE at least NUMBER, or MEASURE is TEXT, with a measure of a sweep"
_CRITERION_PATTERN = re.compile(r"(\w+) (at most|at least|is) (\S.*)")


class Criterion(NamedTuple):
    """A condition on a measure of a run."""

    text: str
    measure: str
    relation: str  # "at most", "at least" or "is"
    value: str

    def is_met(self, measured: Any) -> bool:
        """Whether a run with this value of the measure meets the criterion; NaN never does."""
        if self.relation == "is":
            return str(measured) == self.value
        bound = float(self.value)
        return bool(measured <= bound if self.relation == "at most" else measured >= bound)


def read_criterion(text: str) -> Criterion | None:
    """Parses a criterion; None if it has another form than FORM."""
    match = _CRITERION_PATTERN.fullmatch(text)
    if match is None:
        return None
    criterion = Criterion(text, *match.groups())
    is_bound = is_number(criterion.value.strip()) and math.isfinite(float(criterion.value))
    return criterion if criterion.relation == "is" or is_bound else None
