"""What an environment file may say: one dataclass tree, with a comment and a unit per field."""

from dataclasses import dataclass, field


@dataclass
class ActionConfig:
    """What an action, numbers from -1 to 1, sets: the grip first, then the joints of the arm that move."""

    grip: str = "pressure"  # of all fingers, Pa; or "opening" of the gripper, m, held by the scenario's control
    range: list[float] = field(default_factory=lambda: [0.0, 1e5])  # Pa or m, at -1 and at 1
    rest: float = 0.0  # Pa or m, commanded as an episode begins, until the first action
    joints: dict[str, list[float]] = field(default_factory=dict)  # by name: position at -1 and at 1, m or rad
    settling: float = 0.1  # s, time constant with which a joint goes there: a critically damped second order


@dataclass
class ObservedConfig:
    """A signal of the estimation, of the commands or of the task, as it is observed."""

    signal: str = ""
    entries: list[int] = field(default_factory=list)  # of the signal; none: all
    scale: float = 1.0  # in the unit of the signal, what is observed as 1


@dataclass
class VariationConfig:
    """What differs from episode to episode, evenly distributed; None: as in the scenario."""

    offset: float = 0.0  # m, of where the object begins, along x, either way
    mass: list[float] | None = None  # kg, of the object
    friction: list[float] | None = None  # Coulomb, of the object
    size: list[float] | None = None  # factor of all lengths of the object
    stiffness: list[float] | None = (
        None  # N/m, of the object at a point of contact; evenly distributed in its logarithm
    )
    gripper: str = ""  # name of the model whose fingers differ
    youngs_modulus: float = 0.0  # share of the fingers', either way, which their estimators do not know
    grippers: int = 1  # that are built, with moduli evenly spaced; an episode takes one of them


@dataclass
class ReachConfig:
    """The tip of the one finger follows a point that swings along what the finger can reach."""

    pressure: list[float] = field(default_factory=lambda: [0.0, 1e5])  # Pa, between which it swings
    period: list[float] = field(default_factory=lambda: [2.0, 5.0])  # s, of a swing
    scale: float = 0.01  # m, of the error at which a step earns half


@dataclass
class GraspConfig:
    """The object is to be held up, with little force."""

    object: str = ""  # name of the free model
    height: float = 0.05  # m, to which it is to be lifted
    force_weight: float = 0.2  # 1/N, what the largest force of a finger costs
    crushing_force: float = 5.0  # N, of a finger, that ends an episode


@dataclass
class PickPlaceConfig:
    """The object is to be carried along x, put down and let go."""

    object: str = ""  # name of the free model
    goal: list[float] = field(default_factory=lambda: [0.0, 0.1])  # m, along x in the world, where it is put down
    tolerance: float = 0.01  # m, within which it is there
    force_weight: float = 0.05  # 1/N, what the largest force of a finger costs
    crushing_force: float = 5.0  # N, of a finger, that ends an episode


@dataclass
class EnvironmentConfig:
    """What is simulated, what an agent does, observes and is rewarded for, and what is random."""

    description: str = ""
    scenario: str = ""  # name of a shipped scenario, or path relative to this file; it leaves its commands open
    time_step: float = 0.1  # s, from an action to the next
    duration: float = 5.0  # s, after which an episode is truncated
    action: ActionConfig = field(default_factory=ActionConfig)
    observation: list[ObservedConfig] = field(default_factory=list)
    variation: VariationConfig = field(default_factory=VariationConfig)
    reach: ReachConfig | None = None  # one of the three tasks
    grasp: GraspConfig | None = None
    pick_place: PickPlaceConfig | None = None
