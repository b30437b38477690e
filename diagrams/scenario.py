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
    """Closed loop in the place of pressure steps: the distance between the tips of two fingers is held."""

    set_points: list[float] = field(default_factory=list)  # m, one after the other; empty: open loop
    hold: float = 4.0  # s at every set point
    gains: PidGains = field(default_factory=PidGains)  # from the distance, m, to the pressure, Pa


@dataclass
class SensorConfig:
    """The strain sensors of every finger."""

    sections: int = 4  # sensors one after the other along each path
    period: float = 0.01  # s between samples, and between the samples of every log
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
        return self.steps * self.step_duration
