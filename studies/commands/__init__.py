"""The studies, as `python -m studies --help` lists them; each runs in a module of its name."""

from enum import StrEnum
from functools import partial
from pathlib import Path

from soft_gripper.commands.options import (
    CONSOLE,
    SEED,
    Command,
    Option,
    Program,
    amount,
    count,
    flag,
    folder_option,
    number,
    option,
    path,
    scenario_name,
    whole,
)
from soft_gripper.extras.hardware.commands import DATA
from soft_gripper.extras.sweeps.commands import EXECUTOR, RESUME


def json_file(text: str) -> Path:
    """Reads the path of a JSON file to write."""
    if not text.endswith(".json"):
        raise ValueError("name a .json; the figure is named after it")
    return path(text)


class StudyGroup(StrEnum):
    """Groups under which `--help` lists studies, in this order."""

    ESTIMATES = "errors of estimates, and how often what they state is true"
    RECORDINGS = "recorded data, and scores of estimators"
    REFERENCES = "physics against reference solutions"
    SIMULATORS = "other simulators"
    SPEED = "computing time"
    HOUSE = "the code itself"


def _study(
    group: StudyGroup, folder: str, name: str, line: str, *options: Option, examples: tuple[str, ...] = ("",)
) -> Command:
    """A study whose `run` is in the module of its name in a folder."""
    return Command(name, line, examples, options, package=f"studies.{folder}.{name.replace('-', '_')}", group=group)


_SCENARIOS = option("scenarios", "scenario (default: those of the documentation)", "SCENARIO", scenario_name, nargs="*")
_TIME_STEP = option("--time-step", "time step in MuJoCo (default: that of the scenario)", "S", number(1.0))
_USER_ESTIMATOR = "your own estimator, as MODULE:FUNCTION; may be repeated"
_estimates, _records = partial(_study, StudyGroup.ESTIMATES), partial(_study, StudyGroup.RECORDINGS)
_engines, _speed = partial(_study, StudyGroup.SIMULATORS, "engines"), partial(_study, StudyGroup.SPEED, "speed")
_house = partial(_study, StudyGroup.HOUSE, "house")

COMMANDS = (
    _estimates(
        "commands",
        "contacts",
        "press a finger against random pegs; report errors of contact force and location",
        *CONSOLE,
        count("--trials", "number of contacts", 200),
        SEED,
        amount("--friction", "coefficient of friction of the peg", "MU", 1e2, 0.3),
        amount("--beyond", "share of the length beyond which the finger is pressed", "SHARE", 0.9, 0.4),
        option("--estimator", f"estimator, or {_USER_ESTIMATOR} (default: contact)", "NAME", action="append"),
        *EXECUTOR,
        option("--contacts", "contacts.nc of an earlier run: evaluate these, simulate none", "FILE", path),
        folder_option("results/contacts"),
        examples=(
            "--trials 200 --seed 1",
            "--contacts results/contacts/contacts.nc    contacts of an earlier run again",
        ),
    ),
    _estimates(
        "contacts",
        "contact-coverage",
        "count how often what `contact` states of a force is true, in situations that users meet",
        *CONSOLE,
        amount("--size", "number of contacts, relative to those of the documentation", "SHARE", 100.0, 1.0),
        *(SEED, RESUME, *EXECUTOR, folder_option("results/contact_coverage")),
        examples=("", "--size 0.1 --resume"),
    ),
    _estimates(
        "contacts",
        "model-errors",
        "count how often what `contact` states is true, where finger or scene differ from what is declared",
        *CONSOLE,
        count("--contacts", "number of contacts in each case, and of free fingers", 500),
        *(SEED, RESUME, *EXECUTOR, folder_option("results/model_errors")),
        examples=("", "--contacts 50 --resume"),
    ),
    _estimates(
        "drift",
        "drift",
        "estimate shape and force during an hour of grasping with sensors that drift, by policies of zeroing them",
        *CONSOLE,
        count("--parts", "sets of grasps and sensors, an hour each", 2),
        *(SEED, RESUME, *EXECUTOR, folder_option("results/drift")),
        examples=("", "--parts 4 --resume"),
    ),
    _estimates(
        "health",
        "health",
        "count how many faults of sensors and fingers are found and named, how soon",
        *CONSOLE,
        count("--runs", "number of runs with a fault, and of runs without", 200),
        *(SEED, *EXECUTOR, folder_option("results/health")),
        examples=("", "--runs 16 --out results/some"),
    ),
    _estimates(
        "robustness",
        "robustness",
        "repeat an evaluation with sensor errors, wrong nominal models and other plants",
        *(*CONSOLE, folder_option("results/evaluation"), *EXECUTOR, RESUME),
        count("--seeds", "number of random seeds", 20),
        option("--estimator", _USER_ESTIMATOR, "NAME", action="append", default=[]),
        examples=("                after `soft-gripper evaluate`, in its folder", "--seeds 50 --resume"),
    ),
    _estimates("robustness", "sensor-presets", "errors of shape and torque with every preset of sensor errors"),
    _estimates(
        "benchmark",
        "recognition",
        "how often sensors tell a sphere, a cylinder, a box and an uneven body apart",
        *(*EXECUTOR, folder_option("results")),
    ),
    _estimates(
        "benchmark",
        "softness",
        "how often sensors tell blocks of four materials apart",
        count("--grasps", "number of grasps of a material to train on, and to test", 25),
        *(SEED, *EXECUTOR, folder_option("results/softness")),
    ),
    _records(
        "commands",
        "hardware",
        "identify and replay the published hardware recordings",
        *(*CONSOLE, DATA, folder_option("results/hardware"), *EXECUTOR),
        examples=("--data ~/recordings",),
    ),
    _records(
        "commands",
        "benchmark",
        "score estimators of shape, force, location, load and held objects, with fixed splits",
        *(*CONSOLE, DATA),
        option("estimator", "your own estimator, beside the baselines", "FILE:FUNCTION", nargs="?"),
        option("--submit", "write what your estimator states of every test sample, too", "FILE", json_file),
        option("--score", "score submissions of others instead", "FILE", path, nargs="+", default=[]),
        option("--compare", "print results files beside each other instead", "FILE", path, nargs="+", default=[]),
        option("--out", "file to write (default: %(default)s)", "FILE", json_file, default=Path("benchmark.json")),
        examples=(
            "                                             simulated contacts and grasps, which are here",
            "mine.py:estimator --data ~/recordings        your own estimator, on recorded hardware too",
            "mine.py:estimator --submit mine.json         what it states of every sample, to be scored by others",
            "--score theirs.json --data ~/recordings      scores of such a file, without its code",
            "--compare benchmark.json theirs.json",
        ),
    ),
    _records("benchmark", "benchmark-data", "simulate the contacts and grasps of the benchmark again"),
    _study(
        StudyGroup.REFERENCES,
        "verification",
        "verification",
        "fingers in space against what is known of rods, and their grasps",
        flag("--soft", "soft bodies between plates against closed forms instead"),
    ),
    _study(
        StudyGroup.SIMULATORS,
        "peers",
        "peers",
        "error and computing time of the same fingers in MuJoCo, PyBullet and PyElastica",
        option("tasks", "task of settings.yaml: printed only (default: all, into their page)", "TASK", nargs="*"),
        count("--rounds", "number of alternating rounds", 5),
        examples=("", "'box grasp' --rounds 2"),
    ),
    _engines(
        "engine-agreement",
        "every shipped scenario in MuJoCo and in Drake: tips, forces and ends",
        _SCENARIOS,
        option("--boxes", "draw boxes for box_grasp instead (default: 100)", "N", whole(1), nargs="?", const=100),
        examples=("", "box_grasp", "--boxes 100      random boxes instead"),
    ),
    _engines("export-tips", "fingertips at rest in Drake and, exported, in MuJoCo", _TIME_STEP),
    _engines(
        "export-trials",
        "random grasps in Drake and, exported, in MuJoCo",
        *(_TIME_STEP, count("--trials", "number of grasps", 100), SEED, folder_option("results/export_trials")),
        examples=("--time-step 0.002",),
    ),
    _speed("block-costs", "computing time of the closed diagram and its blocks, beside the bare plant"),
    _speed(
        "compare",
        "computing time of this checkout and of another one, in turns",
        option("other", "folder of the other checkout, with its .venv", "DIR", path),
        _SCENARIOS,
        examples=("../before",),
    ),
    _speed("contact-points", "what contact at points saves and changes in a grasp", _SCENARIOS),
    _speed("work-precision", "error of the fingertips against computing time, by solver"),
    _speed("scaling", "computing time against segments, fingers, objects and sections"),
    _speed("many-runs", "runs per second, overhead and memory of sweeps"),
    _speed(
        "many-grasps",
        "what a thousand box grasps cost in MuJoCo, with one process and with two",
        flag("--varied", "whole scenarios and designs, in MuJoCo and in Drake"),
        flag("--steps", "near the limit of friction, by the step of MuJoCo"),
        option("--runs", "number of runs (default: 1000; 40 with --varied, 60 with --steps)", "N", whole(1)),
        examples=("", "--varied      by what varies, beside Drake"),
    ),
    _speed("learning", "computing time of the environments for learning"),
    _speed(
        "live",
        "latency, losses and memory of `soft-gripper live` over minutes",
        option("--seconds", "duration (default: %(default)s)", "S", number(1e5), default=600.0),
        option("--estimator", "estimator (default: %(default)s)", "NAME", default="gaussian"),
        flag("--page", "with the page, which nobody opens"),
        examples=("--seconds 60 --page",),
    ),
    _speed("play", "how far `soft-gripper play` keeps up with real time", _SCENARIOS),
    _house("house", "size and order of the code, and what grew"),
    _house("words", "words of every page"),
    _house(
        "oracle",
        "numbers of scenarios and contacts before and after a change",
        option("action", "what to do", choices=("store", "compare")),
        option("folder", "where the numbers are", "DIR", path),
        examples=("store results/oracle", "compare results/oracle"),
    ),
)

STUDIES = Program(
    "python -m studies", "Studies that give the numbers of README and docs.", tuple(StudyGroup), lambda: COMMANDS
)
