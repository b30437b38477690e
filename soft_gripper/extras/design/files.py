"""The best design as files: its gripper, a scenario with it, drawings of its sections, and what to cast it with."""

from collections.abc import Mapping
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

import trimesh

from soft_gripper.extras.design.mould import cores, shell
from soft_gripper.extras.design.study_file import DesignStudy
from soft_gripper.files.output import atomic_file, writable_folder
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import changed_urdf
from soft_gripper.pictures.scenes_figure import section_figure
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.finger_changes import mounted_finger
from soft_gripper.scenario.model_files import model_path, mounted_fingers
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario
from soft_gripper.scenario.schema import ModelConfig, Scenario

SCENARIO = "scenario.yaml"


def design_files(scenario: Scenario) -> list[str]:
    """Names of the files that describe a design of a scenario, and could replace those that it was read from."""
    return [SCENARIO, *(f"{model.name}.urdf" for model in scenario.models)]


def write_design(study: DesignStudy, values: Mapping[str, Any], folder: Path) -> list[Path]:
    """Writes a design into a folder; returns the files.

    The models with fingers become URDF files of their own, and the scenario uses these. Fingers that are alike share
    one drawing, one shell and their cores.
    """
    scenario = changed_scenario(study.scenario, {**study.fixed, **values})
    writable_folder(folder)
    fingers, files = list[Finger](), list[Path]()
    for model in scenario.models:
        mounted = mounted_fingers(model, model.name)
        if mounted:
            fingers += [each.finger for each in mounted]
            files.append(_write_gripper(model, folder))
    files.append(_write_scenario(_with_files(scenario, files, folder), folder))
    for finger in _unlike(fingers):
        save_figure(section_figure(finger), folder / f"{finger.name}_section")
        files += [folder / f"{finger.name}_section{suffix}" for suffix in (".png", ".svg")]
        files += _write_moulds(finger, folder)
    return files


def _write_gripper(model: ModelConfig, folder: Path) -> Path:
    change = partial(mounted_finger, where=model.name, configs=model.fingers)
    text = changed_urdf(model_path(model.file), model.segments, model.name, model.without, change)
    return _write(folder / f"{model.name}.urdf", text)


def _with_files(scenario: Scenario, files: list[Path], folder: Path) -> Scenario:
    """The scenario with the written files in place of changes."""
    found = deepcopy(scenario)
    names = {file.stem for file in files}
    for model in found.models:
        if model.name in names:
            model.file, model.fingers, model.segments, model.without = str(folder / f"{model.name}.urdf"), {}, None, []
    return found


def _write_scenario(scenario: Scenario, folder: Path) -> Path:
    return _write(folder / SCENARIO, dump_scenario(scenario, folder))


def _write(path: Path, text: str) -> Path:
    with atomic_file(path) as partial_:
        partial_.write_text(text, encoding="utf-8")
    return path


def _unlike(fingers: list[Finger]) -> list[Finger]:
    """One of all fingers that differ in their names alone."""
    found: dict[str, Finger] = {}
    for finger in fingers:
        found.setdefault(repr(finger).replace(repr(finger.name), ""), finger)
    return list(found.values())


def _write_moulds(finger: Finger, folder: Path) -> list[Path]:
    meshes = {f"{finger.name}_shell.stl": shell(finger)}
    meshes |= {f"{finger.name}_core_{i}.stl": core for i, core in enumerate(cores(finger), 1)}
    return [_write_mesh(folder / name, mesh) for name, mesh in meshes.items()]


def _write_mesh(path: Path, mesh: trimesh.Trimesh) -> Path:
    with atomic_file(path) as partial_:
        partial_.write_bytes(mesh.export(file_type="stl"))
    return path
