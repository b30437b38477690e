"""The parts of a station, in its own diagram or in the user's."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, Diagram, InputPort, OutputPort, System

from soft_gripper.arrays import Array
from soft_gripper.control.task import TaskMachine
from soft_gripper.diagrams.arm import Arm
from soft_gripper.diagrams.provenance import provenance
from soft_gripper.diagrams.recording import Recording, make_recording, read_logs
from soft_gripper.diagrams.scene import Scene, check_starts_apart
from soft_gripper.diagrams.signal_logs import SignalLogs
from soft_gripper.diagrams.task_plan import check_paths
from soft_gripper.diagrams.wiring.drive import External
from soft_gripper.errors import InputError
from soft_gripper.files.notes import Note
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.model_import.imported_model import Mimic
from soft_gripper.scenario.deformables import Deformable
from soft_gripper.scenario.schema import Scenario


@dataclass
class StationParts:
    """The blocks of a scenario in a diagram.

    `inputs` are the commands that the scenario leaves open (`external`), to be connected or exported; `signals` are
    the ports to log, `{finger}.{signal}` and others.
    """

    scenario: Scenario
    plant: MultibodyPlant
    scene_graph: SceneGraph
    fingers: tuple[PlantFinger, ...]
    deformables: Mapping[str, Deformable]  # objects of finite elements, by the names of their models
    mimics: Mapping[str, Sequence[Mimic]]  # joints that follow others, by the names of their models
    sensor: str  # name of the block in tables and recordings
    estimator: str
    inputs: dict[str, InputPort] = field(default_factory=dict)
    signals: dict[str, OutputPort] = field(default_factory=dict)
    arm: Arm | None = None
    task: TaskMachine | None = None  # controller of the task, if there is one
    notes: list[Note] = field(default_factory=list)  # what was mended or left out of the files
    # Of models that have others than the plant in the runs of this station.
    masses: Mapping[str, float] = field(default_factory=dict)  # kg
    frictions: Mapping[str, float] = field(default_factory=dict)

    @property
    def scene(self) -> Scene:
        """The simulated scene; of an arm it does not know how its joints depend on each other."""
        return Scene(self.plant, self.scene_graph, [*self.fingers], self.deformables, None, self.mimics)

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a recording: scenario, versions, frames, notes on its files."""
        return provenance(self.scenario, self.sensor, self.estimator, self.notes)

    def leave_open(self, external: External) -> None:
        """Adds the input of an external command."""
        self.inputs |= external.inputs
        self.signals |= external.signals

    def check(self, diagram: Diagram) -> None:
        """Checks, in the built diagram, the initial state, and the task.

        Raises:
            InputError: if bodies initially penetrate each other, or as `check_task`.
        """
        check_starts_apart(diagram, self.scene_graph)
        self.check_task(diagram)

    def check_task(self, diagram: Diagram, begin: Array | None = None) -> None:
        """Checks, in the built diagram, the paths of a task for collisions; `begin` as for `check_paths`.

        Raises:
            InputError: if a motion of a task collides, or an object that does not give way has a limit of its squeeze.
        """
        task = self.scenario.task
        models = self.scenario.models
        if task is not None and task.squeeze_limit is not None and task.object not in self.deformables:
            expected = f"leave it out: '{task.object}' is rigid"
            raise InputError("task", "squeeze_limit", task.squeeze_limit, expected)
        if task is not None and self.task is not None and self.arm is not None:
            check_paths(diagram, self.plant, self.scene_graph, models, self.arm, task, self.task.phases, begin)


@dataclass(frozen=True)
class Station:
    """A station as a complete diagram, with a log for every signal.

    The output ports of the diagram are the named signals, in a private station those that it computes; its input ports,
    the commands that the scenario leaves open.
    """

    diagram: Diagram
    parts: StationParts
    logs: SignalLogs
    removed: Mapping[str, System] = field(default_factory=dict)  # parts that only the recording computes, by name

    @property
    def scenario(self) -> Scenario:
        return self.parts.scenario

    @property
    def plant(self) -> MultibodyPlant:
        return self.parts.plant

    @property
    def fingers(self) -> tuple[PlantFinger, ...]:
        return self.parts.fingers

    @property
    def task(self) -> TaskMachine | None:
        return self.parts.task

    def recording(self, context: Context, described: bool = True) -> Recording:
        """The recording of all logs, from the context of the root diagram; of a private station not computed yet.

        Without attributes if it is not `described`: the text of a scenario takes longer than a short run.
        """
        attributes = self.parts.attributes if described else {}
        if not self.removed:
            return read_logs(self.logs, context, attributes)
        return make_recording(self.logs.labels, self.logs.samples(context), attributes)
