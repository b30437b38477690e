"""Tables of runs of scenarios with changes, which can be resumed."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from importlib.metadata import version
from pathlib import Path
from typing import Any

from soft_gripper.extras.sweeps.cells import cell
from soft_gripper.extras.sweeps.measured_runs import ERROR, measured_runs
from soft_gripper.extras.sweeps.study import StudyTables
from soft_gripper.files.output import lock_folder
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import DRAKE, Scenario

# Runs per call of an engine other than Drake: more make each faster, but leave processes without work.
_MIN_RUNS_AT_ONCE, _MAX_RUNS_AT_ONCE, _MIN_CALLS = 16, 128, 4


def runs_at_once(scenario: Scenario, count: int) -> int:
    """Best number of runs per call of `run_many`, for `count` runs of a scenario with changes."""
    if scenario.engine == DRAKE:
        return 1
    calls = max(math.ceil(count / _MAX_RUNS_AT_ONCE), min(_MIN_CALLS, math.ceil(count / _MIN_RUNS_AT_ONCE)), 1)
    return max(1, math.ceil(count / calls))


class ScenarioRuns(StudyTables):
    """A table of runs of scenarios with changes: a row has the key of a run, changes, measures, and why it failed."""

    def __init__(self, out: Path, table: str, description: str, keys: Sequence[str], columns: Sequence[str]):
        """`keys` are the columns that identify a run; `columns` are the changed keys of scenarios and the measures.

        Raises:
            InputError: if the folder `out` cannot be written to, or another process writes to it.
        """
        self._names = [*keys, *columns, ERROR]
        super().__init__(lock_folder(out), description, {table: self._names}, len(keys))

    def begin_runs(self, base: Scenario, resume: bool, *packages: str, **parts: Any) -> None:
        """Starts or resumes the table, see `begin`; parts, the scenario and versions tell a study from others.

        `packages` are those that matter beside Drake and numpy.
        """
        versions = {name: version(name) for name in ("soft-gripper", "drake", "numpy", *packages)}
        described = {"versions": versions, "resolved": dump_scenario(base).splitlines()} | parts
        self.begin(json.dumps(described, indent=1, default=str) + "\n", resume)

    def run_changed(
        self,
        executor: Executor,
        base: Scenario,
        given: tuple[str, Mapping[tuple[str, ...], Mapping[str, Any]]],
        fixed_arguments: Sequence[Any],
        report: Callable[[dict[str, str]], Any],
    ) -> None:
        """Makes the runs whose rows do not exist, as many at once as the engine of the scenario is best at.

        Args:
            executor: makes the calls of `measured_runs`.
            base: the scenario, read.
            given: its name or file, and the changes of each run by its key.
            fixed_arguments: further arguments of them.
            report: called with the row of each run.
        """
        scenario, changes = given
        keys = list(changes)
        size = runs_at_once(base, len(keys))
        batches = [tuple(keys[i : i + size]) for i in range(0, len(keys), size)]
        jobs = {batch: (scenario, [changes[key] for key in batch], *fixed_arguments) for batch in batches}

        def keep(batch: tuple[tuple[str, ...], ...], results: Sequence[Mapping[str, Any]]) -> None:
            for key, measures in zip(batch, results, strict=True):
                cells = {**dict(zip(self._names, key, strict=False)), **changes[key], **measures}
                if key not in self.rows:
                    self.add([cell(cells.get(name)) for name in self._names])

        def failed(batch: tuple[tuple[str, ...], ...], error: str) -> list[dict[str, Any]]:
            return [{ERROR: error}] * len(batch)

        def ended(batch: tuple[tuple[str, ...], ...]) -> None:
            for key in batch:
                report(self.row(key))

        self.run(executor, measured_runs, jobs, keep, failed, ended, keys=lambda batch: batch)

    def row(self, key: tuple[str, ...]) -> dict[str, str]:
        """The cells of a run by column."""
        return dict(zip(self._names, self.rows[key][0], strict=True))
