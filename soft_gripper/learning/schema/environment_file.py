"""load_environment: YAML -> what an environment is made of, checked."""

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.files.document import load_config
from soft_gripper.files.text import name_of
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.learning.schema.config import EnvironmentConfig, VariationConfig
from soft_gripper.quantity import Misfit
from soft_gripper.scenario.drake_values import without_numpy
from soft_gripper.scenario.scenario import FingerChanges, Scenario
from soft_gripper.scenario.scenario_file import change_document, changed_scenario

SHIPPED = Path(__file__).parents[1] / "environments"
_OF_SCENARIO = "scenario."


@dataclass(frozen=True)
class Environment:
    """An environment's own file, and the scenario that it names, with the commands left open that an action gives."""

    config: EnvironmentConfig
    scenario: Scenario


def environment_names() -> list[str]:
    """Names of the shipped environments."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_environment(name_or_path: str, changes: Mapping[str, Any] | None = None) -> Environment:
    """Reads a shipped environment by its name, or any environment file by its path.

    Args:
        name_or_path: such as "soft_grasp", or "my/environment.yaml".
        changes: plain data by dotted keys in the place of what the file says, such as {"variation.mass": [0.02, 0.03]};
            of its scenario by keys that begin with "scenario.".

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    path, changes = _find(name_or_path), dict(changes or {})
    of_scenario = {
        key.removeprefix(_OF_SCENARIO): changes.pop(key) for key in [*changes] if key.startswith(_OF_SCENARIO)
    }
    config = _read(path, changes)
    scenario = config.scenario
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(path.parent / scenario)
    commands = [config.action.grip, *(["joints"] if config.action.joints else [])]
    environment = Environment(config, changed_scenario(scenario, {"external": commands} | of_scenario))
    for field, value, expected in _misfits(config, environment.scenario):
        raise InputError(path, field, value, expected)
    return environment


def _find(name_or_path: str) -> Path:
    name_or_path = name_of(name_or_path)
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    if name_or_path not in environment_names():
        expected = f"not shipped; known: {', '.join(environment_names())}"
        raise InputError("environment", "name", name_or_path, expected)
    return SHIPPED / f"{name_or_path}.yaml"


def _read(path: Path, changes: Mapping[str, Any]) -> EnvironmentConfig:
    document = read_yaml(path)
    for key, value in changes.items():
        try:
            change_document(document, key, copy.deepcopy(without_numpy(value)))
        except LookupError as error:
            raise InputError("change", "key", key, str(error.args[0])) from None
    return load_config(path, document, EnvironmentConfig)


def _misfits(config: EnvironmentConfig, scenario: Scenario) -> Iterator[Misfit]:
    """What of an environment does not go with its scenario; names of signals are checked when it is built."""
    period, names = scenario.sensor.period, [model.name for model in scenario.models]
    if config.time_step < period:
        yield "time_step", config.time_step, f"must be at least the sensors' period, {period:g} s"
    variation, share = config.variation, config.variation.youngs_modulus
    if share > 0 and variation.gripper not in names:
        yield "variation.gripper", variation.gripper, f"must be one of the models: {', '.join(names)}"
    if share > 0 and variation.grippers > 1 and any(f.youngs_modulus for f in _finger_changes(variation, scenario)):
        yield "variation.youngs_modulus", share, "must be 0, since the scenario gives the fingers another"
    free = [model.name for model in scenario.models if model.free]
    for name, task in (("grasp", config.grasp), ("pick_place", config.pick_place)):
        if task is not None and task.object not in free:
            yield f"{name}.object", task.object, f"must be one of the free models: {', '.join(free)}"


def _finger_changes(variation: VariationConfig, scenario: Scenario) -> Iterator[FingerChanges]:
    """What the scenario changes of the fingers that differ, and what is believed of them."""
    yield scenario.believed
    for model in scenario.models:
        if model.name == variation.gripper:
            yield from model.fingers.values()
