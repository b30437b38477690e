"""What an environment file may say: one dataclass tree, with a comment, a unit and a range per field."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from soft_gripper.quantity import Misfit, quantity

TASKS = ("reach", "grasp", "pick_place")


@dataclass
class ActionConfig:
    """What an action, numbers from -1 to 1, sets: the grip first, then the joints of the arm that move."""

    # "pressure" of all fingers, Pa; or "opening" of the gripper, m, held by the scenario's control
    grip: str = quantity("pressure", known=("pressure", "opening"))
    range: list[float] = quantity([0.0, 1e5], "Pa or m", span=True)  # at -1 and at 1
    rest: float = quantity(0.0, "Pa or m")  # commanded as an episode begins, until the first action
    joints: dict[str, list[float]] = quantity({}, "m or rad", span=True)  # by name: position at -1 and at 1
    # Time constant with which a joint goes there: a critically damped second order.
    settling: float = quantity(0.1, "s", above=0)

    def misfits(self) -> Iterator[Misfit]:
        spans = {"range": self.range, **{f"joints.{name}": limits for name, limits in self.joints.items()}}
        for name, (least, most) in spans.items():
            if least == most:
                yield name, [least, most], "must be two different numbers: an action is a share of the span"
        if not self.range[0] <= self.rest <= self.range[1]:
            yield "rest", self.rest, f"must be within the range, {self.range[0]:g} to {self.range[1]:g}"


@dataclass
class ObservedConfig:
    """A signal of the estimation, of the commands or of the task, as it is observed."""

    signal: str = ""
    entries: list[int] = field(default_factory=list)  # of the signal; none: all
    scale: float = quantity(1.0, above=0)  # in the unit of the signal, what is observed as 1


@dataclass
class VariationConfig:
    """What differs from episode to episode, evenly distributed; None: as in the scenario."""

    offset: float = quantity(0.0, "m", least=0)  # of where the object begins, along x, either way
    mass: list[float] | None = quantity(None, "kg", above=0, span=True)  # of the object
    friction: list[float] | None = quantity(None, above=0, span=True)  # Coulomb, of the object
    size: list[float] | None = quantity(None, above=0, span=True)  # factor of all lengths of the object
    # Of the object at a point of contact; evenly distributed in its logarithm.
    stiffness: list[float] | None = quantity(None, "N/m", above=0, span=True)
    gripper: str = ""  # name of the model whose fingers differ
    # Share of the fingers', either way, which their estimators do not know.
    youngs_modulus: float = quantity(0.0, least=0, below=1)
    grippers: int = quantity(1, least=1)  # that are built, with moduli evenly spaced; an episode takes one of them


@dataclass
class ReachConfig:
    """The tip of the one finger follows a point that swings along what the finger can reach."""

    pressure: list[float] = quantity([0.0, 1e5], "Pa", span=True)  # between which it swings
    period: list[float] = quantity([2.0, 5.0], "s", above=0, span=True)  # of a swing
    scale: float = quantity(0.01, "m")  # of the error at which a step earns half


@dataclass
class GraspConfig:
    """The object is to be held up, with little force."""

    object: str = ""  # name of the free model
    height: float = quantity(0.05, "m")  # to which it is to be lifted
    force_weight: float = quantity(0.2, "1/N")  # what the largest force of a finger costs
    crushing_force: float = quantity(5.0, "N", above=0)  # of a finger, that ends an episode


@dataclass
class PickPlaceConfig:
    """The object is to be carried along x, put down and let go."""

    object: str = ""  # name of the free model
    goal: list[float] = quantity([0.0, 0.1], "m", span=True)  # along x in the world, where it is put down
    tolerance: float = quantity(0.01, "m")  # within which it is there
    force_weight: float = quantity(0.05, "1/N")  # what the largest force of a finger costs
    crushing_force: float = quantity(5.0, "N", above=0)  # of a finger, that ends an episode


@dataclass
class EnvironmentConfig:
    """What is simulated, what an agent does, observes and is rewarded for, and what is random."""

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
        """The tasks that are given, of which there must be one."""
        return [name for name in TASKS if getattr(self, name) is not None]

    def misfits(self) -> Iterator[Misfit]:
        if self.duration < self.time_step:
            yield "duration", self.duration, f"must be at least time_step, {self.time_step:g} s"
        if len(self.tasks) != 1:
            yield "task", self.tasks, f"must be one of {', '.join(TASKS)}"
