"""The schema of an environment file: one dataclass tree, with a comment, a unit and a range per field."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.files.document import load_config
from soft_gripper.files.text import name_of
from soft_gripper.quantity import Violation, quantity
from soft_gripper.scenario.scenario_file import changed_scenario, load_changed
from soft_gripper.scenario.schema import Scenario

TASKS = ("reach", "grasp", "pick_place")


@dataclass
class ActionConfig:
    """Meaning of an action, numbers from -1 to 1: the grip first, then the joints of the arm that move."""

    # "pressure" of all fingers, Pa; or "opening" of the gripper, m, held by the scenario's control
    grip: str = quantity("pressure", known=("pressure", "opening"))
    range: list[float] = quantity([0.0, 1e5], "Pa or m", span=True)  # at -1 and at 1
    rest: float = quantity(0.0, "Pa or m")  # command at the start of an episode, until the first action
    joints: dict[str, list[float]] = quantity({}, "m or rad", span=True)  # by name: position at -1 and at 1
    # Time constant of a joint's motion, critically damped of second order.
    settling: float = quantity(0.1, "s", above=0)

    def violations(self) -> Iterator[Violation]:
        spans = {"range": self.range, **{f"joints.{name}": limits for name, limits in self.joints.items()}}
        for name, (low, high) in spans.items():
            if low == high:
                yield name, [low, high], "must be two different numbers: an action is a fraction of the span"
        if not self.range[0] <= self.rest <= self.range[1]:
            yield "rest", self.rest, f"must be within the range, {self.range[0]:g} to {self.range[1]:g}"


@dataclass
class ObservedConfig:
    """Observed signal of the estimation, of the commands or of the task."""

    signal: str = ""
    entries: list[int] = field(default_factory=list)  # of the signal; none: all
    scale: float = quantity(1.0, above=0)  # the value that is observed as 1, in the unit of the signal


@dataclass
class VariationConfig:
    """Variation between episodes, uniformly distributed; None: as in the scenario."""

    offset: float = quantity(0.0, "m", least=0)  # of the object's start along x, in both directions
    mass: list[float] | None = quantity(None, "kg", above=0, span=True)  # of the object
    friction: list[float] | None = quantity(None, above=0, span=True)  # Coulomb, of the object
    size: list[float] | None = quantity(None, above=0, span=True)  # factor of all lengths of the object
    # Of the object at a point of contact; log-uniformly distributed.
    stiffness: list[float] | None = quantity(None, "N/m", above=0, span=True)
    gripper: str = ""  # name of the model whose fingers vary
    # Fraction by which the fingers' modulus varies, up and down, unknown to their estimators.
    youngs_modulus: float = quantity(0.0, least=0, below=1)
    grippers: int = quantity(1, least=1)  # built, with evenly spaced moduli; an episode uses one of them


@dataclass
class ReachConfig:
    """Task: the tip of the only finger follows a point that swings within its reach."""

    pressure: list[float] = quantity([0.0, 1e5], "Pa", span=True)  # between which it swings
    period: list[float] = quantity([2.0, 5.0], "s", above=0, span=True)  # of a swing
    scale: float = quantity(0.01, "m")  # error at which a step earns half


@dataclass
class GraspConfig:
    """Task: the object must be held up, with little force."""

    object: str = ""  # name of the free model
    height: float = quantity(0.05, "m")  # to which it must be lifted
    force_weight: float = quantity(0.2, "1/N")  # penalty on the largest force of a finger
    crushing_force: float = quantity(5.0, "N", above=0)  # of a finger, that ends an episode


@dataclass
class PickPlaceConfig:
    """Task: the object must be carried along x, put down and released."""

    object: str = ""  # name of the free model
    goal: list[float] = quantity([0.0, 0.1], "m", span=True)  # along x in the world, where it is put down
    tolerance: float = quantity(0.01, "m")  # within which it is there
    force_weight: float = quantity(0.05, "1/N")  # penalty on the largest force of a finger
    crushing_force: float = quantity(5.0, "N", above=0)  # of a finger, that ends an episode


@dataclass
class EnvironmentConfig:
    """The scenario, actions, observations, reward and random variation of an environment."""

    description: str = ""
    scenario: str = ""  # name of a shipped scenario, or path relative to this file; it leaves its commands open
    time_step: float = quantity(0.1, "s", above=0)  # from an action to the next
    duration: float = quantity(5.0, "s", above=0)  # after which an episode is truncated
    action: ActionConfig = field(default_factory=ActionConfig)
    observation: list[ObservedConfig] = quantity([], filled=True)
    variation: VariationConfig = field(default_factory=VariationConfig)
    reach: ReachConfig | None = None  # one of the three tasks
    grasp: GraspConfig | None = None
    pick_place: PickPlaceConfig | None = None

    @property
    def tasks(self) -> list[str]:
        """Tasks that the file sets; exactly one is valid."""
        return [name for name in TASKS if getattr(self, name) is not None]

    def violations(self) -> Iterator[Violation]:
        if self.duration < self.time_step:
            yield "duration", self.duration, f"must be at least time_step, {self.time_step:g} s"
        if len(self.tasks) != 1:
            yield "task", self.tasks, f"must be one of {', '.join(TASKS)}"


SHIPPED = Path(__file__).with_name("environments")
_SCENARIO_PREFIX = "scenario."


@dataclass(frozen=True)
class Environment:
    """An environment file and its scenario, whose commands are left to the actions."""

    config: EnvironmentConfig
    scenario: Scenario


def environment_names() -> list[str]:
    """Names of the shipped environments."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_environment(name_or_path: str, changes: Mapping[str, Any] | None = None) -> Environment:
    """Reads a shipped environment by its name, or any environment file by its path.

    Args:
        name_or_path: such as "soft_grasp", or "my/environment.yaml".
        changes: plain data that replaces values of the file, by dotted keys, such as {"variation.mass": [0.02, 0.03]};
            of its scenario by keys that begin with "scenario.".

    Raises:
        InputError: naming file, key and value, if the file or a change is invalid.
    """
    path, changes = _find(name_or_path), dict(changes or {})
    scenario_changes = {
        key.removeprefix(_SCENARIO_PREFIX): changes.pop(key) for key in [*changes] if key.startswith(_SCENARIO_PREFIX)
    }
    config = load_changed("change", path, changes, lambda document: load_config(path, document, EnvironmentConfig))
    scenario = config.scenario
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(path.parent / scenario)
    commands = [config.action.grip, *(["joints"] if config.action.joints else [])]
    environment = Environment(config, changed_scenario(scenario, {"external": commands} | scenario_changes))
    for key, value, expected in _violations(config, environment.scenario):
        raise InputError(path, key, value, expected)
    return environment


def _find(name_or_path: str) -> Path:
    name_or_path = name_of(name_or_path)
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    if name_or_path not in environment_names():
        expected = f"not shipped; known: {', '.join(environment_names())}"
        raise InputError("environment", "name", name_or_path, expected)
    return SHIPPED / f"{name_or_path}.yaml"


def _violations(config: EnvironmentConfig, scenario: Scenario) -> Iterator[Violation]:
    """Contradictions between an environment and its scenario; names of signals are checked when it is built."""
    period, names = scenario.sensor.period, [model.name for model in scenario.models]
    if config.time_step < period:
        yield "time_step", config.time_step, f"must be at least the sensors' period, {period:g} s"
    variation, modulus_variation = config.variation, config.variation.youngs_modulus
    if modulus_variation > 0 and variation.gripper not in names:
        yield "variation.gripper", variation.gripper, f"must be one of the models: {', '.join(names)}"
    if (
        modulus_variation > 0
        and variation.grippers > 1
        and any("youngs_modulus" in key for key in _changed_paths(variation, scenario))
    ):
        yield "variation.youngs_modulus", modulus_variation, "must be 0, since the scenario sets the fingers' modulus"
    free_names = [model.name for model in scenario.models if model.free]
    for name, task in (("grasp", config.grasp), ("pick_place", config.pick_place)):
        if task is not None and task.object not in free_names:
            yield f"{name}.object", task.object, f"must be one of the free models: {', '.join(free_names)}"


def _changed_paths(variation: VariationConfig, scenario: Scenario) -> Iterator[str]:
    """Yields paths of the scenario's changes of the varied fingers, and of their nominal model."""
    yield from scenario.nominal.finger
    for model in scenario.models:
        if model.name == variation.gripper:
            yield from chain.from_iterable(model.fingers.values())
