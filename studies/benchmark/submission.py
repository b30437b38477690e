"""Writes and reads submissions: the estimates of every test sample, and the checksums of the data.

They are JSON. With the data they can be scored without the code of the estimator.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.json_text import read_json
from soft_gripper.files.output import atomic_file
from studies.benchmark.benchmark_task import VERSION, BenchmarkTask, Part, Tested
from studies.benchmark.estimates import Answers, Estimated, check_estimate

_SIGNIFICANT_DIGITS = 7  # of an estimate


@dataclass(frozen=True)
class Submission:
    """A submission as it was read."""

    file: Path
    estimator: str
    tasks: Mapping[str, Any]  # their contents, by name

    def answers(self, task: BenchmarkTask, tested: Tested) -> Answers:
        """Estimates for a task, which may lack regions of recordings that were kept back.

        Raises:
            InputError: if it is of other data, or of other samples.
        """
        content = self._mapping(self.tasks[task.name], task.name)
        files, regions = (self._mapping(content.get(key), f"{task.name}.{key}") for key in ("sha256", "regions"))
        more_files = {part.file for region in task.further for part in task.tested[region]}
        for file in files.keys() | (task.sha256.keys() - more_files):
            if files.get(file) != task.sha256.get(file):
                checksum = task.sha256.get(file)
                expected = "the data folder has no such file" if checksum is None else f"must be {checksum}"
                raise InputError(self.file, f"{task.name}.sha256.{file}", files.get(file), expected)
        if not tested.keys() - task.further <= regions.keys() <= tested.keys():
            raise InputError(self.file, f"{task.name}.regions", [*regions], f"must be {', '.join(tested)}")
        return {region: self._parts(task, region, regions[region], tested) for region in tested if region in regions}

    def _parts(self, task: BenchmarkTask, region: str, parts: Any, tested: Tested) -> list[Estimated]:
        field, recordings = f"{task.name}.regions.{region}", tested[region]
        if not isinstance(parts, list) or len(parts) != len(recordings):
            raise InputError(self.file, field, type(parts).__name__, f"must be a list of {len(recordings)} parts")
        mappings = [self._mapping(part, field) for part in parts]
        return [
            check_estimate(
                f"{self.file}, {region}", task.question, len(recorded.inputs), part.get("mean"), part.get("std")
            )
            for part, recorded in zip(mappings, recordings, strict=True)
        ]

    def _mapping(self, value: Any, field: str) -> Mapping[str, Any]:
        if not isinstance(value, dict):
            raise InputError(self.file, field, type(value).__name__, "must be an object")
        return value


def write_submission(file: Path, estimator: str, answers_by_task: Mapping[BenchmarkTask, Answers]) -> None:
    """Writes the estimates of an estimator for tasks."""
    head = {"benchmark": VERSION, "soft_gripper": version("soft-gripper"), "estimator": estimator}
    tasks = {
        task.name: {
            "inputs": [f"{channel.name} [{channel.unit}]" for channel in task.inputs],
            "outputs": [f"{channel.name} [{channel.unit}]" for channel in task.outputs],
            "sha256": dict(task.sha256),
            "regions": {region: list(map(_contents, task.tested[region], answers[region])) for region in task.tested},
        }
        for task, answers in answers_by_task.items()
    }
    with atomic_file(file) as partial:
        partial.write_text(json.dumps(head | {"tasks": tasks}) + "\n", encoding="utf-8")


def read_submission(file: Path) -> Submission:
    """Reads a submission.

    Raises:
        InputError: if it is none, or of another version of the benchmark.
    """
    document = read_json(file)
    try:
        stated_version, estimator, tasks = document["benchmark"], document["estimator"], dict(document["tasks"])
    except (ValueError, KeyError, TypeError):
        raise InputError(file, "file", file.name, "was not written by python -m studies benchmark --submit") from None
    if stated_version != VERSION:
        raise InputError(file, "benchmark", stated_version, f"must be {VERSION}: tasks and data are others")
    if not isinstance(estimator, str):
        raise InputError(file, "estimator", estimator, "must be a name")
    return Submission(file, estimator, tasks)


def _contents(part: Part, estimate: Estimated) -> dict[str, Any]:
    std = None if estimate.std is None else _rounded(estimate.std)
    return {"file": part.file, "begin": part.begin, "end": part.end, "mean": _rounded(estimate.mean), "std": std}


def _rounded(values: Array) -> list[list[float]]:
    return [[float(f"{value:.{_SIGNIFICANT_DIGITS}g}") for value in row] for row in values]
