"""soft-gripper doctor: which parts of the installation work, and which are missing."""

import argparse
import os
import platform
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from soft_gripper.commands.options import PROGRAM, ExitCode
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat
from soft_gripper.errors import InputError, first_line
from soft_gripper.files.output import writable_folder
from soft_gripper.model_import.mesh_files import cache_folder
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.scenario_file import load_scenario

PACKAGES = ("drake", "numpy", "scipy", "matplotlib", "xarray")
EXTRAS = {
    "notebooks": "pygraphviz",
    "video": "imageio_ffmpeg",
    "c3d": "ezc3d",
    "cluster": "distributed",
    "learning": "gymnasium",
}
SHORT = ["pressure.steps.all=[10e3]", "pressure.settle=0.05", "pressure.hold_samples=1"]
MAPS = Path("/proc/self/maps")  # the libraries of this process, on Linux
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox")


@dataclass(frozen=True)
class Finding:
    """The state of one part of the installation.

    works: None for an optional part that is missing.
    """

    part: str
    works: bool | None
    found: str


def run(options: argparse.Namespace) -> ExitCode:
    """Runs the command."""
    findings = [
        Finding("python", True, f"{platform.python_version()} on {platform.platform()}"),
        *(Finding(name, True, version(name)) for name in (PROGRAM, *PACKAGES)),
        Finding("cores", True, str(os.cpu_count())),
        _optional(
            "allocator", _allocator(), "that of the C library; LD_PRELOAD of tcmalloc or jemalloc speeds up contact"
        ),
        _try("simulation and pictures", _draws_a_run),
        _try("Meshcat", lambda: f"served at {hidden_meshcat().web_url()}"),
        _try("mesh cache", lambda: f"{writable_folder(cache_folder())} is writable"),
        _optional("browser", next(filter(None, map(shutil.which, BROWSERS)), None), "none on the PATH"),
        *(
            _optional(f"extra {name}", _version(module), f"pip install 'soft-gripper[{name}]'")
            for name, module in EXTRAS.items()
        ),
    ]
    width = max(len(finding.part) for finding in findings)
    for finding in findings:
        mark = {True: "ok", False: "FAILS", None: "-"}[finding.works]
        print(f"{finding.part:<{width}}  {mark:<5}  {finding.found}")
    options.console.table("findings", findings)
    return ExitCode.FAILED if any(finding.works is False for finding in findings) else ExitCode.DONE


def _try(part: str, act: Callable[[], str]) -> Finding:
    try:
        return Finding(part, True, act())
    except Exception as error:  # any error is a finding to report
        return Finding(part, False, first_line(error))


def _optional(part: str, result: str | None, missing: str) -> Finding:
    return Finding(part, None, missing) if result is None else Finding(part, True, result)


def _allocator() -> str | None:
    """The library that replaces the C library's malloc, if that is known."""
    match = re.search(r"lib(?:tc|je|mi)malloc[^/\n]*$", MAPS.read_text(), re.MULTILINE) if MAPS.exists() else None
    return match and match[0]


def _version(module: str) -> str | None:
    if find_spec(module) is None:
        return None
    try:
        return version(module.replace("_", "-"))
    except PackageNotFoundError:
        return "there"


def _draws_a_run() -> str:
    scenario = load_scenario("free_bending", SHORT)
    picture = SceneRenderer(scenario, simulate(scenario), height=120).render(scenario.duration)
    shades = len(np.unique(picture))
    if shades < 2:
        raise InputError(
            "render engine", "picture", "one shade only", "an image with content; check that VTK can use EGL or GLX"
        )
    return f"a finger bends, in a picture of {shades} shades"
