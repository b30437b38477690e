"""The whole schema of a scenario file, on one page. SI units; every field is explained beside it.

A field that may be left out, and then means that there is no such thing, is None.
"""

import math
from dataclasses import dataclass, field

from pydrake.common.schema import Transform
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.drake_values import ByValue


@dataclass
class MeshConfig:
    """What a model that is a bare mesh file lacks; its inertia follows from its shape."""

    scale: float = 1.0  # metres in a unit of the file: 0.001 if it is in millimetres
    mass: float = 0.05  # kg, spread evenly over the volume
    friction: float = 0.8  # Coulomb, static and dynamic alike
    color: list[float] = field(default_factory=lambda: [0.45, 0.62, 0.36, 1.0])  # red, green, blue, opacity


@dataclass
class FingerChanges:
    """Values in the units of a <finger>, or relative changes, "+10 %"; of a cross-section, for base and tip alike."""

    length: str | None = None  # m
    width: str | None = None  # m
    thickness: str | None = None  # m
    youngs_modulus: str | None = None  # Pa
    density: str | None = None  # kg/m^3
    chamber_width: str | None = None  # m
    chamber_thickness: str | None = None  # m
    chamber_center: str | None = None  # m
    layer_thickness: str | None = None  # m
    layer_modulus: str | None = None  # Pa
    relaxation_time: str | None = None  # s
    sensor_spacing: str | None = None  # m

    def __post_init__(self) -> None:
        """Numbers are meant as their text."""
        for name, value in vars(self).items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                setattr(self, name, str(value))


@dataclass
class FingerConfig(FingerChanges):
    """What of a simulated finger differs from its file."""

    shear_factor: str | None = None  # 1
    friction: str | None = None  # Coulomb, static and dynamic alike
    hydroelastic_modulus: str | None = None  # Pa
    dissipation: str | None = None  # s/m


@dataclass(eq=False)
class ModelConfig(ByValue):
    """A model and where it stands."""

    name: str = ""  # of the model; a model with a single finger gives the finger its name
    file: str = ""  # package:// URI or path relative to the scenario file; a URDF may hold <finger>s
    parent: str = "world"  # frame that it is welded to: "world" or "model::frame"
    child: str | None = None  # frame of the model that is welded; None: its first link
    X_PC: Transform = field(default_factory=Transform)  # child frame in the parent frame
    free: bool = False  # not welded: X_PC in the world is where its first link begins
    without: list[str] = field(default_factory=list)  # links of a URDF that are left out, with all that hangs on them
    segments: int | None = None  # of every finger in the file; None: as the file says
    fingers: dict[str, FingerConfig] = field(default_factory=dict)  # changes of its <finger>s, by name or for "all"
    mesh: MeshConfig = field(default_factory=MeshConfig)  # for a file that is a bare mesh (.obj, .stl, .ply ...)


@dataclass
class PressureConfig:
    """The pressure supply, and the pressure in steps where nothing else commands it."""

    steps: dict[str, list[float]] = field(default_factory=lambda: {"all": [0.0]})  # Pa, by finger or "all"
    settle: float = 1.0  # s before the samples of a step begin
    hold_samples: int = 100  # sensor samples averaged in each step
    minimum: float = -50e3  # Pa, of the supply (negative: vacuum, which the walls of the chamber must bear)
    maximum: float = 210e3  # Pa
    time_constant: float = 0.05  # s, first-order lag between command and chamber; 0: none


@dataclass
class ControlConfig:
    """Closed loop: the opening of the gripper, held through the pressure of all its fingers.

    The opening is twice the mean distance of the fingertips from their centroid: of two, their distance.
    """

    set_points: list[float] | None = None  # m, one after the other; None: a task or an input gives them, or open loop
    hold: float = 4.0  # s at every set point
    gains: PidGains = field(default_factory=PidGains)  # from the opening, m, to the pressure, Pa
    torque_limit: float | None = None  # N m, at the base of the fingers, that a grip does not exceed
    torque_gains: PidGains = field(default_factory=PidGains)  # from that torque to the pressure, Pa
    force_limit: float | None = None  # N, estimated contact force of the fingers (mean), in the place of a torque_limit
    force_gains: PidGains = field(default_factory=PidGains)  # from that force to the pressure, Pa


@dataclass
class ArmConfig:
    """The arm among the models: the gripper is welded to one of its frames. Every joint has an implicit PD."""

    model: str = ""  # its name
    home: list[float] = field(default_factory=list)  # rad or m, posture in which it begins; joints from the base on
    frequency: float = 10.0  # Hz, natural frequency of a joint under its PD
    damping_ratio: float = 1.0  # of the same
    acceleration: float = 10.0  # rad/s^2 or m/s^2, of any joint at most; velocity and effort are limited by its file


@dataclass
class PhaseConfig:
    """A part of a task. The arm moves, or stays if neither `to` nor `posture` is given; then `until` is awaited."""

    name: str = ""
    to: str | None = None  # where the gripper goes: "object", "goal" or "home"
    height: float = 0.0  # m, above where it grasps or puts down
    posture: list[float] | None = None  # or: where the arm's joints go, rad or m
    straight: bool = False  # the gripper goes in a straight line; else the joints do
    speed: float = 1.0  # part of the arm's velocity limits
    opening: float | None = None  # m, set point of the gripper from here on; None: as before
    until: str | None = None  # what ends it after the motion: "opened", "grasped", "released"; None: `rest` is over
    rest: float = 0.0  # s, after the motion, where nothing is awaited
    holds: bool = False  # the object is in the fingers: its loss is watched for


@dataclass
class PoseErrorConfig:
    """The pose of an object as a camera reports it, minus the true one. Its height above a known table is known."""

    x: float = 0.0  # m, in the world
    y: float = 0.0  # m, in the world
    yaw: float = 0.0  # rad, about the vertical through the origin of its first link


@dataclass
class TrialsConfig:
    """What random trials of a task vary about its scenario, evenly distributed, either way or from least to most."""

    offset: float = 0.03  # m, of where the object begins, along x and along y
    yaw: float = math.radians(45)  # rad, of the object about its own z axis
    mass: list[float] = field(default_factory=lambda: [0.02, 0.06])  # kg
    friction: list[float] = field(default_factory=lambda: [0.5, 0.9])
    size: float = 0.1  # share of the object's
    offset_error: float = 3e-3  # m, of the reported pose along x and along y: that of a common depth camera
    yaw_error: float = math.radians(3)  # rad, of the reported pose about the vertical


@dataclass(eq=False)
class TaskConfig(ByValue):
    """What the arm does, phase after phase; where a phase gives an opening, the gripper too, in closed loop."""

    object: str | None = None  # name of the free model that is handled; only where it is reported to begin is known
    X_OG: Transform = field(default_factory=Transform)  # grasp: the gripper's welded frame in the object's first link
    X_WGoal: Transform = field(default_factory=Transform)  # where the object is put down, its first link in the world
    phases: list[PhaseConfig] = field(default_factory=list)
    grip_threshold: float = 0.02  # N m, torque at the base of the fingers that counts as a grip
    quiet_band: float = 5e-4  # m, within which the estimated opening of a gripper at rest stays; more for noisy sensors
    timeout: float = 4.0  # s, that a phase waits at most for what is to end it
    time_limit: float = 60.0  # s, for all of it
    force_limit: float | None = None  # N, normal force of a finger that the object bears; what trials are judged by
    pose_error: PoseErrorConfig = field(default_factory=PoseErrorConfig)  # of the reported pose, which motions go by
    trials: TrialsConfig = field(default_factory=TrialsConfig)  # of `soft-gripper grasp-trials`

    @property
    def grips(self) -> bool:
        """Whether the task commands the gripper."""
        return any(phase.opening is not None for phase in self.phases)


@dataclass
class DeadSensorConfig:
    """A strain sensor that reads nothing."""

    path: str = "outer"  # "inner" or "outer"
    section: int = 0  # from the base


@dataclass
class StrainErrorsConfig:
    """The errors of the strain sensors, in the order in which they act on the extension ratio; docs/sensors.md.

    What is None is as the preset has it; without a preset there is no such error. Strain is the extension ratio - 1;
    standard deviations are those of independent draws for every sensor.
    """

    preset: str | None = None  # a kind of sensor, see sensor_presets.yaml
    creep: float | None = None  # share of the strain that comes late, 0 to 1
    creep_time: float | None = None  # s, time constant with which it comes
    hysteresis: float | None = None  # width of the loop of a cycle over its stroke, 0 to 0.1
    gain_error: float | None = None  # standard deviation, of one draw a run, as a share of the strain
    offset: float | None = None  # standard deviation, of one draw a run, extension ratio
    drift: float | None = None  # standard deviation of what a steady drift reaches in a minute, extension ratio
    low_frequency_noise: float | None = None  # standard deviation of a Gauss-Markov process, extension ratio
    correlation_time: float | None = None  # s, of that process
    noise: float | None = None  # standard deviation, white, of every sample, extension ratio
    saturation: list[float] | None = None  # least and greatest extension ratio that is read
    quantization: float | None = None  # step of the extension ratio
    delay: int | None = None  # samples
    dropout: float | None = None  # probability that a sample of a sensor is lost, and reads NaN
    dead: list[DeadSensorConfig] = field(default_factory=list)  # sensors that always read NaN


@dataclass
class PressureErrorsConfig:
    """The errors of the pressure sensor, in the order in which they act."""

    gain_error: float = 0.0  # standard deviation, of one draw a run, as a share of the pressure
    offset: float = 0.0  # standard deviation, of one draw a run, Pa
    noise: float = 0.0  # standard deviation, white, of every sample, Pa
    delay: int = 0  # samples


@dataclass
class SensorConfig:
    """The sensors of every finger."""

    type: str = "strain"  # or "module:function" of your own, see diagrams/wiring/named_blocks.py
    sections: int = 4  # sensors one after the other along each path
    borders: list[float] | None = None  # where sections meet, as shares of the length; None: they are equally long
    period: float = 0.01  # s between samples, and between the samples of every log
    one_sided: bool = False  # only the outer path is measured, the inner side does not stretch
    response: list[list[float]] | None = None  # [extension ratio, reading] points; None: the reading is the strain
    errors: StrainErrorsConfig | None = None  # of the strain sensors; None: they are ideal
    pressure_errors: PressureErrorsConfig | None = None  # of the pressure sensor; None: it is ideal
    seed: int = 0  # of all random numbers of the sensors


@dataclass
class EstimatorConfig:
    """What is estimated from the readings of every finger."""

    type: str = "arcs"  # of the shape: see docs/estimators.md; or "module:function" of your own
    beside: list[str] = field(default_factory=list)  # other types, whose shapes are recorded too and used by nothing
    # For estimators that weigh what they know; None: as it follows from the errors of the sensors.
    uncertainty: Uncertainty | None = None
    compensate_gravity: bool = True  # take the finger's own weight out of the force estimate
    contact_threshold: float | None = None  # N m, of the torque that means contact; None: contact is not looked for


@dataclass
class BelievedConfig(FingerChanges):
    """What the estimators believe of every finger and its sensors where it differs from what is simulated."""

    file: str | None = None  # URDF whose <finger> of the same name, or only one, is believed; changes come on top
    creep: bool = True  # whether the estimators know that the finger creeps, if it does
    response: list[list[float]] | None = None  # of the sensors; None: as they are
    calibration: str | None = None  # file that `soft-gripper calibrate` wrote, applied to what is believed so far


def default_plant_config() -> MultibodyPlantConfig:
    """Discrete steps of 10 ms; a time_step of 0 is continuous. The choice is measured in docs/solver.md."""
    return MultibodyPlantConfig(time_step=0.01, use_sampled_output_ports=False)


def default_simulator_config() -> SimulatorConfig:
    """For a continuous plant; beside a discrete one nothing is left to integrate."""
    return SimulatorConfig(integration_scheme="cenic", max_step_size=0.02, accuracy=1e-3)


@dataclass(eq=False)
class Scenario(ByValue):
    """What is simulated, how it is driven, sensed and estimated, and by which solver."""

    description: str = ""
    models: list[ModelConfig] = field(default_factory=list)
    gravity: list[float] = field(default_factory=lambda: [0.0, 0.0, -9.81])  # m/s^2, in the world
    pressure: PressureConfig = field(default_factory=PressureConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    arm: ArmConfig | None = None
    task: TaskConfig | None = None
    # Commands that are input ports of the station, for a diagram around it: "pressure" of every finger, or the
    # "opening" of the gripper; and, with an arm, its "joints", or the pose of the "tool".
    external: list[str] = field(default_factory=list)
    sensor: SensorConfig = field(default_factory=SensorConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    believed: BelievedConfig = field(default_factory=BelievedConfig)
    plant_config: MultibodyPlantConfig = field(default_factory=default_plant_config)
    simulator_config: SimulatorConfig = field(default_factory=default_simulator_config)

    @property
    def steps(self) -> int:
        """Number of steps, of pressure or, in closed loop, of the set point."""
        if self.control.set_points is not None:
            return len(self.control.set_points)
        return max(len(steps) for steps in self.pressure.steps.values())

    @property
    def step_duration(self) -> float:
        """Time from one step to the next, s."""
        if self.control.set_points is not None:
            return self.control.hold
        return self.pressure.settle + self.pressure.hold_samples * self.sensor.period

    @property
    def duration(self) -> float:
        """Of the run, s; a task may be over before."""
        if self.task is not None:
            return self.task.time_limit
        return self.steps * self.step_duration
