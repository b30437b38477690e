"""The studies, as `python -m studies --help` lists them; each runs in a module of its name."""

from enum import StrEnum
from pathlib import Path

from soft_gripper.commands.options import (
    CONSOLE,
    DATA,
    EXECUTOR,
    RESUME,
    SEED,
    Command,
    Program,
    count,
    flag,
    json_file,
    number,
    option,
    out,
    path,
    scenario_name,
    whole,
)


class Group(StrEnum):
    """The groups by which `--help` lists studies, in that order."""

    ESTIMATES = "errors of estimates, and how often what they state is true"
    RECORDINGS = "recorded data, and scores of estimators"
    REFERENCES = "physics against reference solutions"
    SIMULATORS = "other simulators"
    SPEED = "computing time"
    HOUSE = "the code itself"


_SCENARIOS = option("scenarios", "scenario (default: those of the documentation)", "SCENARIO", scenario_name, nargs="*")
_TIME_STEP = option("--time-step", "time step in MuJoCo (default: that of the scenario)", "S", number(1.0))

COMMANDS = (
    Command(
        "contacts",
        "press a finger against random pegs; report errors of contact force and location",
        (
            "--trials 200 --seed 1",
            "--contacts results/contacts/contacts.nc    evaluate the contacts of an earlier run again",
        ),
        (
            *CONSOLE,
            count("--trials", "number of contacts", 200),
            SEED,
            option(
                "--friction",
                "coefficient of friction of the peg's surface (default: %(default)s)",
                "MU",
                number(100.0),
                default=0.3,
            ),
            option(
                "--beyond",
                "share of the length beyond which the finger is pressed (default: %(default)s)",
                "SHARE",
                number(0.9),
                default=0.4,
            ),
            option(
                "--estimator",
                "estimator of force and location, or your own as MODULE:FUNCTION; may be repeated (default: contact)",
                "NAME",
                action="append",
            ),
            *EXECUTOR,
            option("--contacts", "contacts.nc of an earlier run: evaluate these, simulate none", "FILE", path),
            out("results/contacts"),
        ),
        package=__name__,
        group=Group.ESTIMATES,
    ),
    Command(
        "contact-coverage",
        "count how often what `contact` states of a force is true, in situations that users meet",
        ("", "--size 0.1 --resume"),
        (
            *CONSOLE,
            option(
                "--size",
                "number of contacts, relative to those of the documentation (default: %(default)g)",
                "SHARE",
                number(100.0),
                default=1.0,
            ),
            SEED,
            RESUME,
            *EXECUTOR,
            out("results/contact_coverage"),
        ),
        package=__name__,
        group=Group.ESTIMATES,
    ),
    Command(
        "model-errors",
        "count how often what `contact` states is true, where finger or scene differ from what is declared",
        ("", "--contacts 50"),
        (
            *CONSOLE,
            count("--contacts", "number of contacts in each case, and of free fingers", 500),
            SEED,
            *EXECUTOR,
            out("results/model_errors"),
        ),
        package=__name__,
        group=Group.ESTIMATES,
    ),
    Command(
        "drift",
        "estimate shape and force during an hour of grasping, with sensors that drift, under policies of zeroing them",
        ("", "--parts 4 --resume"),
        (
            *CONSOLE,
            count("--parts", "sets of grasps and sensors, an hour each", 2),
            SEED,
            RESUME,
            *EXECUTOR,
            out("results/drift"),
        ),
        package=__name__,
        group=Group.ESTIMATES,
    ),
    Command(
        "robustness",
        "repeat an evaluation with sensor errors, wrong nominal models and other plants",
        (
            "                after `soft-gripper evaluate`, in its folder",
            "--seeds 50      more draws of the sensor errors",
            "--resume        finish what was interrupted",
        ),
        (
            *CONSOLE,
            out("results/evaluation"),
            *EXECUTOR,
            RESUME,
            count("--seeds", "number of random seeds", 20),
            option(
                "--estimator",
                "your own estimator, as MODULE:FUNCTION; may be repeated",
                "NAME",
                action="append",
                default=[],
            ),
        ),
        package=__name__,
        group=Group.ESTIMATES,
    ),
    Command(
        "hardware",
        "identify and replay the published hardware recordings",
        ("--data ~/recordings",),
        (*CONSOLE, DATA, out("results/hardware"), *EXECUTOR),
        package=__name__,
        group=Group.RECORDINGS,
    ),
    Command(
        "benchmark",
        "score estimators of shape, force, location, load and held objects, with fixed splits",
        (
            "                                  simulated contacts and grasps, which are here",
            "mine.py:estimator --data ~/recordings            your own estimator, on recorded hardware too",
            "mine.py:estimator --submit mine.json             what it states of every sample, to be scored by others",
            "--score theirs.json --data ~/recordings          scores of such a file, without its code",
            "--compare benchmark.json theirs.json",
        ),
        (
            *CONSOLE,
            DATA,
            option("estimator", "your own estimator, beside the baselines", "FILE:FUNCTION", nargs="?"),
            option("--submit", "write what your estimator states of every test sample, too", "FILE", json_file),
            option("--score", "score submissions of others instead", "FILE", path, nargs="+", default=[]),
            option("--compare", "print results files beside each other instead", "FILE", path, nargs="+", default=[]),
            option("--out", "file to write (default: %(default)s)", "FILE", json_file, default=Path("benchmark.json")),
        ),
        package=__name__,
        group=Group.RECORDINGS,
    ),
    Command(
        "benchmark-data",
        "simulate the contacts and grasps of the benchmark again",
        ("",),
        (),
        package="studies.benchmark",
        group=Group.RECORDINGS,
    ),
    Command(
        "sensor-presets",
        "errors of shape and torque with every preset of sensor errors",
        ("",),
        (),
        package="studies.robustness",
        group=Group.ESTIMATES,
    ),
    Command(
        "recognition",
        "how often sensors tell a sphere, a cylinder, a box and an uneven body apart",
        ("",),
        (*EXECUTOR, out("results")),
        package="studies.benchmark",
        group=Group.ESTIMATES,
    ),
    Command(
        "softness",
        "how often sensors tell blocks of four materials apart",
        ("",),
        (
            count("--grasps", "number of grasps of a material to train on, and to test", 25),
            SEED,
            *EXECUTOR,
            out("results/softness"),
        ),
        package="studies.benchmark",
        group=Group.ESTIMATES,
    ),
    Command(
        "verification",
        "fingers in space against what is known of rods, and their grasps",
        ("",),
        (),
        package="studies",
        group=Group.REFERENCES,
    ),
    Command(
        "verification-soft",
        "soft bodies between plates against closed forms",
        ("",),
        (),
        package="studies.verification",
        group=Group.REFERENCES,
    ),
    Command(
        "peers",
        "error and computing time of the same fingers in MuJoCo, PyBullet and PyElastica",
        ("", "'box grasp' --rounds 2"),
        (
            option(
                "tasks",
                "task of settings.yaml: printed only (default: all, written into their page)",
                "TASK",
                nargs="*",
            ),
            count("--rounds", "number of alternating rounds", 5),
        ),
        package="studies",
        group=Group.SIMULATORS,
    ),
    Command(
        "engine-agreement",
        "every shipped scenario in MuJoCo and in Drake: tips, forces and ends",
        ("", "box_grasp", "--boxes 100      random boxes instead"),
        (
            _SCENARIOS,
            option("--boxes", "draw boxes for box_grasp instead (default: 100)", "N", whole(1), nargs="?", const=100),
        ),
        package="studies.engines",
        group=Group.SIMULATORS,
    ),
    Command(
        "export-tips",
        "fingertips at rest in Drake and, exported, in MuJoCo",
        ("", "--time-step 0.002"),
        (_TIME_STEP,),
        package="studies.engines",
        group=Group.SIMULATORS,
    ),
    Command(
        "export-trials",
        "random grasps in Drake and, exported, in MuJoCo",
        ("--time-step 0.002",),
        (_TIME_STEP, count("--trials", "number of grasps", 100), SEED, out("results/export_trials")),
        package="studies.engines",
        group=Group.SIMULATORS,
    ),
    Command(
        "design-ranks",
        "whether MuJoCo ranks the designs of a search as Drake does",
        ("examples/design/bottle.yaml results/design",),
        (
            option("study", "YAML file of the search", read=path),
            option("results", "folder of its results", read=path),
            count("--designs", "number of designs", 20),
        ),
        package="studies.engines",
        group=Group.SIMULATORS,
    ),
    Command(
        "block-costs",
        "computing time of the closed diagram and its blocks, beside the bare plant",
        ("",),
        (),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "compare",
        "computing time of this checkout and of another one, in turns",
        ("../before",),
        (option("other", "folder of the other checkout, with its .venv", "DIR", path), _SCENARIOS),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "contact-points",
        "what contact at points saves and changes in a grasp",
        ("",),
        (_SCENARIOS,),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "work-precision",
        "error of the fingertips against computing time, by solver",
        ("",),
        (),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "scaling",
        "computing time against segments, fingers, objects and sections",
        ("",),
        (),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "many-runs",
        "runs per second, overhead and memory of sweeps",
        ("",),
        (),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "many-grasps",
        "what a thousand box grasps cost in MuJoCo, with one process and with two",
        ("", "--varied      by what varies, beside Drake"),
        (
            flag("--varied", "whole scenarios and designs, in MuJoCo and in Drake"),
            option("--runs", "number of runs (default: 1000; 40 with --varied)", "N", whole(1)),
        ),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "learning",
        "computing time of the environments for learning",
        ("",),
        (),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "live",
        "latency, losses and memory of `soft-gripper live` over minutes",
        ("--seconds 60 --page",),
        (
            option("--seconds", "duration (default: %(default)s)", "S", number(1e5), default=600.0),
            option("--estimator", "estimator (default: %(default)s)", "NAME", default="gaussian"),
            flag("--page", "with the page, which nobody opens"),
        ),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command(
        "play",
        "how far `soft-gripper play` keeps up with real time",
        ("",),
        (_SCENARIOS,),
        package="studies.speed",
        group=Group.SPEED,
    ),
    Command("house", "size and order of the code, and what grew", ("",), (), package="studies", group=Group.HOUSE),
    Command("words", "words of every page", ("",), (), package="studies.house", group=Group.HOUSE),
    Command(
        "oracle",
        "numbers of scenarios and contacts before and after a change",
        ("store results/oracle", "compare results/oracle"),
        (
            option("action", "what to do", choices=("store", "compare")),
            option("folder", "where the numbers are", "DIR", path),
        ),
        package="studies.house",
        group=Group.HOUSE,
    ),
)

STUDIES = Program(
    "python -m studies", "Studies that give the numbers of README and docs.", tuple(Group), lambda: COMMANDS
)
