"""The whole schema of a scenario file, on one page. SI units; every field is explained beside it."""

from dataclasses import dataclass, field

from pydrake.common.schema import Transform
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig

from soft_gripper.pid_controller import PidGains


@dataclass
class MeshConfig:
    """What a model that is a bare mesh file lacks; its inertia follows from its shape."""

    scale: float = 1.0  # metres in a unit of the file: 0.001 if it is in millimetres
    mass: float = 0.05  # kg, spread evenly over the volume
    friction: float = 0.8  # Coulomb, static and dynamic alike
    color: list[float] = field(default_factory=lambda: [0.45, 0.62, 0.36, 1.0])  # red, green, blue, opacity


@dataclass
class ModelConfig:
    """A model and where it stands."""

    name: str = ""  # of the model; a model with a single finger gives the finger its name
    file: str = ""  # package:// URI or path relative to the scenario file; a URDF may hold <finger>s
    parent: str = "world"  # frame that it is welded to: "world" or "model::frame"
    child: str = ""  # frame of the model that is welded; empty: its first link
    X_PC: Transform = field(default_factory=Transform)  # child frame in the parent frame
    free: bool = False  # not welded: X_PC in the world is where its first link begins
    without: list[str] = field(default_factory=list)  # links of a URDF that are left out, with all that hangs on them
    segments: int = 0  # of every finger in the file; 0: as the file says
    mesh: MeshConfig = field(default_factory=MeshConfig)  # for a file that is a bare mesh (.obj, .stl, .ply ...)


@dataclass
class PressureConfig:
    """The input: pressure in steps; each step settles and is then held while samples are averaged."""

    steps: dict[str, list[float]] = field(default_factory=lambda: {"all": [0.0]})  # Pa, by finger or "all"
    settle: float = 1.0  # s before the samples of a step begin
    hold_samples: int = 100  # sensor samples averaged in each step
    minimum: float = -60e3  # Pa, of the supply (negative: vacuum)
    maximum: float = 250e3  # Pa
    time_constant: float = 0.05  # s, first-order lag between command and chamber; 0: none


@dataclass
class ControlConfig:
    """Closed loop in the place of pressure steps: set points of the tips' distance are given here or by a task."""

    set_points: list[float] = field(default_factory=list)  # m, one after the other; empty: open loop, or a task
    hold: float = 4.0  # s at every set point
    gains: PidGains = field(default_factory=PidGains)  # from the distance, m, to the pressure, Pa
    torque_limit: float = 0.0  # N m, at the base of the fingers, that a grip does not exceed; 0: none
    torque_gains: PidGains = field(default_factory=PidGains)  # from that torque to the pressure, Pa


@dataclass
class ArmConfig:
    """The arm among the models: the gripper is welded to one of its frames. Every joint has an implicit PD."""

    model: str = ""  # its name; empty: there is no arm
    home: list[float] = field(default_factory=list)  # rad or m, posture in which it begins; joints from the base on
    frequency: float = 10.0  # Hz, natural frequency of a joint under its PD
    damping_ratio: float = 1.0  # of the same
    acceleration: float = 10.0  # rad/s^2 or m/s^2, of any joint at most; velocity and effort are limited by its file


@dataclass
class PhaseConfig:
    """A part of a task. The arm moves, or stays if neither `to` nor `posture` is given; then `until` is awaited."""

    name: str = ""
    to: str = ""  # where the gripper goes: "object", "goal" or "home"
    height: float = 0.0  # m, above where it grasps or puts down
    posture: list[float] = field(default_factory=list)  # or: where the arm's joints go, rad or m
    straight: bool = False  # the gripper goes in a straight line; else the joints do
    speed: float = 1.0  # part of the arm's velocity limits
    distance: float = 0.0  # m, set point between the fingertips from here on; 0: as before
    until: str = ""  # what ends the phase after the motion: "grasped", "released", or empty: `rest` is over
    rest: float = 0.0  # s, after the motion, where nothing is awaited
    holds: bool = False  # the object is in the fingers: its loss is watched for


@dataclass
class TaskConfig:
    """What arm and gripper do, phase after phase, in the place of pressure steps and set points."""

    object: str = ""  # name of the free model that is handled; where it begins is known, what becomes of it is felt
    X_OG: Transform = field(default_factory=Transform)  # grasp: the gripper's welded frame in the object's first link
    X_WGoal: Transform = field(default_factory=Transform)  # where the object is put down, its first link in the world
    phases: list[PhaseConfig] = field(default_factory=list)
    grip_threshold: float = 0.02  # N m, torque at the base of the fingers that is felt when something is held
    timeout: float = 4.0  # s, that a phase waits at most for what is to end it
    time_limit: float = 60.0  # s, for all of it
    force_limit: float = 0.0  # N, normal force of a finger that the object bears; what trials are judged by; 0: none


@dataclass
class SensorConfig:
    """The strain sensors of every finger."""

    sections: int = 4  # sensors one after the other along each path
    period: float = 0.01  # s between samples, and between the samples of every log
    contact_threshold: float = 0.0  # N m, of the torque that tells contact; 0: contact is not looked for
    one_sided: bool = False  # only the outer path is measured, the inner side does not stretch
    compensate_gravity: bool = True  # take the finger's own weight out of the force estimate
    response: list[list[float]] = field(default_factory=list)  # [extension ratio, reading] points; empty: linear


def default_plant_config() -> MultibodyPlantConfig:
    """Discrete steps of 10 ms; a time_step of 0 is continuous. The choice is measured in docs/solver.md."""
    return MultibodyPlantConfig(time_step=0.01, use_sampled_output_ports=False)


def default_simulator_config() -> SimulatorConfig:
    """For a continuous plant; beside a discrete one nothing is left to integrate."""
    return SimulatorConfig(integration_scheme="cenic", max_step_size=0.02, accuracy=1e-3)


@dataclass
class Scenario:
    """What is simulated, how it is driven and sensed, and by which solver."""

    description: str = ""
    models: list[ModelConfig] = field(default_factory=list)
    gravity: list[float] = field(default_factory=lambda: [0.0, 0.0, -9.81])  # m/s^2, in the world
    pressure: PressureConfig = field(default_factory=PressureConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    arm: ArmConfig = field(default_factory=ArmConfig)
    task: TaskConfig = field(default_factory=TaskConfig)
    sensor: SensorConfig = field(default_factory=SensorConfig)
    plant_config: MultibodyPlantConfig = field(default_factory=default_plant_config)
    simulator_config: SimulatorConfig = field(default_factory=default_simulator_config)

    @property
    def steps(self) -> int:
        """Number of steps, of pressure or, in closed loop, of the set point."""
        if self.control.set_points:
            return len(self.control.set_points)
        return max(len(steps) for steps in self.pressure.steps.values())

    @property
    def step_duration(self) -> float:
        """Time from one step to the next, s."""
        if self.control.set_points:
            return self.control.hold
        return self.pressure.settle + self.pressure.hold_samples * self.sensor.period

    @property
    def duration(self) -> float:
        """Of the run, s; a task may be over before."""
        if self.task.phases:
            return self.task.time_limit
        return self.steps * self.step_duration
