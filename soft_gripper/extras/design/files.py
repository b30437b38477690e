"""The best design as files: its gripper, a scenario with it, drawings of its sections, and its moulds."""

from collections.abc import Mapping
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

from soft_gripper.extras.design.mould import cores, shell
from soft_gripper.extras.design.study_file import DesignStudy
from soft_gripper.files.output import atomic_folder
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import changed_urdf
from soft_gripper.pictures.section_figure import section_figure
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.finger_changes import mounted_finger
from soft_gripper.scenario.model_files import model_path, mounted_fingers
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario

SCENARIO = "scenario.yaml"


def write_design(study: DesignStudy, values: Mapping[str, Any], folder: Path) -> list[Path]:
    """Writes a design into a folder; returns the files.

    The models with fingers become URDF files of their own, and the scenario uses these. Fingers that are alike share
    one drawing, one shell and their cores.
    """
    scenario = deepcopy(changed_scenario(study.scenario, {**study.fixed, **values}))
    fingers = list[Finger]()
    with atomic_folder(folder) as partial_folder:
        for model in scenario.models:
            if mounts := mounted_fingers(model, model.name):
                fingers += [element.finger for element in mounts]
                change = partial(mounted_finger, where=model.name, configs=model.fingers)
                file = f"{model.name}.urdf"
                text = changed_urdf(model_path(model.file), model.segments, model.name, model.without, change)
                (partial_folder / file).write_text(text, encoding="utf-8")
                model.file, model.fingers, model.segments, model.without = str(folder / file), {}, None, []
        (partial_folder / SCENARIO).write_text(dump_scenario(scenario, folder), encoding="utf-8")
        for finger in {repr(finger.unnamed): finger for finger in reversed(fingers)}.values():
            save_figure(section_figure(finger), partial_folder / f"{finger.name}_section")
            shell(finger).export(partial_folder / f"{finger.name}_shell.stl")
            for i, core in enumerate(cores(finger), 1):
                core.export(partial_folder / f"{finger.name}_core_{i}.stl")
        names = [file.name for file in partial_folder.iterdir()]
    return [folder / name for name in sorted(names)]
