"""The command line: every command with its options, help and examples.

Nothing here imports Drake or numpy, so that help, completion and usage errors are reported at once. The module of
a command, which has its name and a function `run`, is imported when the command runs.
"""

import argparse
import os
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

import shtab

from soft_gripper.errors import InputError, in_one_line, shortened
from soft_gripper.scenario.shipped import preset_names, scenario_names, scenario_path

PROGRAM = "soft-gripper"
LOOPBACK = "127.0.0.1"


class ExitCode(IntEnum):
    """The exit codes of all commands."""

    DONE = 0
    FAILED = 1  # a task or a claim failed
    REFUSED = 2  # invalid input, or a file that cannot be written
    INTERRUPTED = 130  # Ctrl-C
    BROKEN_PIPE = 141  # the reader of the output has exited; the code that shells report


Read = Callable[[str], Any]  # text -> value; raises a ValueError that says what is expected


@dataclass(frozen=True)
class Option:
    """An option, with all its names, or a positional argument.

    settings: keyword arguments of `argparse.ArgumentParser.add_argument`.
    """

    names: list[str]
    read: Read | None
    settings: dict[str, Any]


def option(names: str, help_: str, metavar: str | None = None, read: Read | None = None, **settings: Any) -> Option:
    """An option with a value, or a positional argument."""
    return Option(names.split(), read, {"help": help_, "metavar": metavar, **settings})


def flag(names: str, help_: str) -> Option:
    """An option without a value."""
    return Option(names.split(), None, {"help": help_, "action": "store_true"})


def whole(least: int, most: int = 10_000) -> Callable[[str], int]:
    """Reads a whole number within limits; the default upper limit is the most that anyone would wait for."""

    def read(text: str) -> int:
        number = int(text) if text.isascii() and text.isdecimal() and len(text) <= 10 else None
        if number is None or not least <= number <= most:
            raise ValueError(f"give a whole number from {least} to {most}")
        return number

    return read


def number(most: float, is_most_allowed: bool = True) -> Callable[[str], float]:
    """Reads a number from 0 to `most`."""

    def read(text: str) -> float:
        with suppress(ValueError):
            if 0 <= (value := float(text)) < most or (is_most_allowed and value == most):
                return value
        raise ValueError(f"give a number from 0 to {'' if is_most_allowed else 'below '}{most:g}")

    return read


def path(text: str) -> Path:
    """Reads a path; ~ is the user's home folder, even if no shell has expanded it."""
    if not text or "\0" in text:
        raise ValueError("give a path")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise ValueError(str(error)) from None


def mcap_path(text: str) -> Path:
    """Reads a path that ends in .mcap."""
    if not text.endswith(".mcap"):
        raise ValueError("give a name that ends in .mcap")
    if find_spec("mcap") is None:  # found out before a run, not after it
        raise ValueError("MCAP files require mcap: pip install 'soft-gripper[ros]'")
    return path(text)


def scenario_name(text: str) -> str:
    """Reads the name of a shipped scenario, or the path of a file."""
    if not os.path.exists(scenario_path(text)):
        raise ValueError("there is no such file")
    return text


def scenario_list(text: str) -> list[str]:
    """Reads names separated by commas."""
    return [scenario_name(name) for name in text.split(",")]


def preset(text: str) -> str | None:
    """Reads the name of a preset of sensor errors; None for ideal sensors."""
    if text == "ideal":
        return None
    if text not in preset_names():
        raise ValueError(f"known: ideal, {', '.join(preset_names())}")
    return text


def assignment(text: str) -> str:
    """Checks that text has the form KEY=VALUE."""
    if not text.partition("=")[0] or "=" not in text:
        raise ValueError("write key=value, such as sensor.sections=3")
    return text


def urdf(text: str) -> Path:
    """Reads the path of a URDF to write."""
    if not text.endswith(".urdf"):
        raise ValueError("name a .urdf; the table and the figure are named after it")
    return path(text)


def json_file(text: str) -> Path:
    """Reads the path of a JSON file to write."""
    if not text.endswith(".json"):
        raise ValueError("name a .json; the figure is named after it")
    return path(text)


CONSOLE = (
    flag("-q --quiet", "print errors only"),
    flag("--json", "print tables and file names as one JSON document instead of text"),
    flag("--traceback", "print the traceback if your own sensor or estimator fails"),
)
SEED = option("--seed", "random seed (default: %(default)s)", "N", whole(0, 2**32 - 1), default=1)
RESUME = flag("--resume", "run only what an interrupted run left unfinished")
HTML = option("--html", "write a 3-D animation that opens offline", "FILE", path)
HOST = option(
    "--host",
    "address at which the page is served (default: %(default)s, for this machine only; 0.0.0.0: for the network)",
    "ADDRESS",
    default=LOOPBACK,
)
MCAP = option("--mcap", "write an MCAP file, and a layout for Foxglove beside it", "FILE.mcap", mcap_path)
SCHEDULER = option(
    "--scheduler",
    "Dask scheduler whose workers to use instead, such as tcp://127.0.0.1:8786; see docs/cluster.md",
    "URL",
)
JOBS = option("--jobs", "number of processes (default: one per core)", "N", whole(1, 256), default=os.cpu_count() or 1)
EXECUTOR = (JOBS, SCHEDULER)
DESCRIBED_AS = option("--as", "description of the data: shipped, or a YAML file", "NAME", dest="described_as")
RECORDINGS = (option("file", "recording; searched for here, then in the data folder", nargs="+"), DESCRIBED_AS)
DATA = option("--data", "data folder (default: $SOFT_GRIPPER_DATA)", "DIR", path)


def scenario(default: str | None = None) -> tuple[Option, ...]:
    """A scenario, with an optional default, and overrides."""
    described = "a shipped scenario (see `soft-gripper list`) or a YAML file"
    optional = {"nargs": "?", "default": default} if default else {}
    changes = "change a field, such as pressure.settle=2 or models.3.mesh.mass=0.1; may be repeated"
    return (
        option(
            "scenario", f"{described}; default: {default}" if default else described, None, scenario_name, **optional
        ),
        option("--sections", "sensor sections along each side of a finger", "N", whole(1)),
        option("--set", changes, "KEY=VALUE", assignment, action="append", default=[]),
    )


def out(default: str) -> Option:
    """The folder for the results."""
    return option("--out", "folder for the results (default: %(default)s)", "DIR", path, default=Path(default))


def count(name: str, help_: str, default: int, least: int = 1) -> Option:
    """A count with a default."""
    return option(name, f"{help_} (default: %(default)s)", "N", whole(least), default=default)


def _check_sweep(options: argparse.Namespace) -> None:
    options.method = options.method or ("grid" if options.sample is None else "latin")
    if (options.method == "grid") != (options.sample is None):
        expected = "give --sample N" if options.sample is None else "omit --sample: a grid has all combinations"
        raise InputError("sweep", "--method", options.method, expected)


def _check_place_sensors(options: argparse.Namespace) -> None:
    if options.recordings and options.scenarios:
        expected = "omit it: sensors are placed either for scenarios or for recordings"
        raise InputError("place-sensors", "--scenarios", ",".join(options.scenarios), expected)


def _check_trials(options: argparse.Namespace) -> None:
    """Tables distinguish scenarios by their names alone."""
    names = Counter(Path(file).stem for file in options.scenario or ())
    for file in options.scenario or ():
        if names[Path(file).stem] > 1:
            raise InputError("grasp-trials", "--scenario", file, "give scenarios with different names")


@dataclass(frozen=True)
class Command:
    """A command; its module `soft_gripper.commands.NAME` has a function `run`, which takes the options.

    does: what it does, as a phrase for `--help`.
    examples: command lines without the name, each with an optional explanation after two or more spaces.
    check: checks options that depend on each other.
    """

    name: str
    does: str
    examples: tuple[str, ...]
    options: tuple[Option, ...]
    check: Callable[[argparse.Namespace], None] = lambda options: None

    @property
    def module(self) -> str:
        return f"soft_gripper.commands.{self.name.replace('-', '_')}"


COMMANDS = (
    Command(
        "run",
        "run a scenario and record every signal",
        (
            "box_grasp                          write tables and every signal to results/box_grasp",
            "box_grasp --meshcat                watch it in a browser",
            "box_grasp --html animation.html    save a 3-D animation that opens offline",
            "my_scenario.yaml --set sensor.sections=2 --json",
        ),
        (
            *CONSOLE,
            *scenario(),
            option(
                "--out",
                "folder for the results (default: results/SCENARIO, or SCENARIO-2 ... if that holds another run)",
                "DIR",
                path,
            ),
            flag("--meshcat", "show the run in a browser, and wait when it ends"),
            HOST,
            HTML,
            option("--video", "write a video: .mp4, .gif, .webp or .png", "FILE", path),
            MCAP,
        ),
    ),
    Command(
        "play",
        "move the gripper yourself, live in a browser",
        (
            "box_grasp                        command pressures with sliders and keys",
            "tip_distance_steps               command the gripper opening, held by its controller",
            "pick_and_place_box --grip pressure --set sensor.sections=2",
        ),
        (
            *scenario("box_grasp"),
            option(
                "--grip",
                "what the sliders command (default: the opening if the scenario controls it)",
                choices=("pressure", "opening"),
            ),
            option("--out", "folder for recordings (default: results/play/SCENARIO)", "DIR", path),
            HOST,
        ),
    ),
    Command(
        "live",
        "estimate from the sensors of hardware, in real time, and command it",
        (
            "tip_distance_steps                                the simulated twin in the place of hardware",
            "tip_distance_steps --bench bench.yaml --zero 2    readings and commands as bench.yaml describes",
            "tip_distance_steps --page                         the same in a browser, to look at",
            "my_scenario.yaml --source udp://:6000 --out results/monday",
        ),
        (
            *scenario(),
            option("--bench", "description of the hardware (default: the scenario's)", "FILE", path),
            option("--source", "address of the readings, instead of the one in the description", "ADDRESS"),
            option("--sink", "address that results are sent to, instead of that one", "ADDRESS"),
            option(
                "--zero",
                "s at the beginning in which the fingers are free, to zero the sensors",
                "S",
                number(60),
                default=0.0,
            ),
            option(
                "--seconds", "how long to run (default: until Ctrl-C, or the end of the readings)", "S", number(1e7)
            ),
            flag("--fast", "use the readings of a file as fast as possible"),
            flag("--page", "show estimates, contacts and the counts of readings in a browser; zero and record there"),
            flag("--twin", "with --page and --bench: show a simulated twin beside the hardware, commanded alike"),
            HOST,
            option("--out", "folder for a recording of every signal; with --page, for its recordings", "DIR", path),
            MCAP,
        ),
    ),
    Command(
        "evaluate",
        "run the paper's evaluation with 1 to 4 sensors per side",
        (
            "                    write report.html, tables and figures, and check each claim",
            "--robustness        include sensor errors, wrong nominal models and other plants",
            "--resume            finish an interrupted evaluation",
        ),
        (
            *CONSOLE,
            out("results/evaluation"),
            *EXECUTOR,
            RESUME,
            flag("--robustness", "also evaluate with sensor errors, wrong nominal models and other plants"),
            count("--seeds", "number of random seeds with --robustness", 20),
            option(
                "--estimator",
                "with --robustness, your own estimator, as MODULE:FUNCTION; may be repeated",
                "NAME",
                action="append",
                default=[],
            ),
        ),
    ),
    Command(
        "sweep",
        "run a scenario with many values of its fields, and write one table",
        (
            "box_grasp --vary sensor.sections=1,2,4 --vary 'nominal.youngs_modulus=-20..20 %:5' --out results/nominal",
            "tip_distance_steps --vary control.gains.ki=1e5..1e6 --sample 64 --seed 1 --out results/gains",
            "box_grasp --vary sensor.sections=1,2,4 --out results/sections --resume    finish an interrupted sweep",
        ),
        (
            *CONSOLE,
            *scenario(),
            option(
                "--vary",
                "values or a range of a field, like pressure.maximum=1e5,2e5 or nominal.youngs_modulus=-20..20 %%:5;"
                " whole numbers stay whole; may be repeated",
                "KEY=VALUES",
                assignment,
                action="append",
                required=True,
            ),
            option("--method", "default: grid; latin with --sample", choices=("grid", "latin", "sobol")),
            option("--sample", "number of points drawn from the values and ranges", "N", whole(1)),
            SEED,
            option(
                "--measure",
                "your own measure, a function of station and recording, as one more column; may be repeated",
                "MODULE:FUNCTION",
                action="append",
                default=[],
            ),
            flag("--check-step", "repeat each run with half the time step, and name the measures that depend on it"),
            option("--out", "folder for the table", "DIR", path, required=True),
            RESUME,
            *EXECUTOR,
        ),
        _check_sweep,
    ),
    Command(
        "design",
        "search the best design of a gripper for a set of objects, and test it",
        (
            "examples/design/bottle.yaml --out results/bottle    tables, Pareto front, gripper, drawings, mould",
            "my_study.yaml --out results/mine --resume           go on after an interruption",
        ),
        (
            *CONSOLE,
            option(
                "study", "YAML file: what varies, what must be held, and to which ends; see docs/design.md", read=path
            ),
            RESUME,
            *EXECUTOR,
            out("results/design"),
        ),
    ),
    Command(
        "grasp-strength",
        "load a held object in twelve directions until it is lost",
        (
            "bottle_grasp                                   six forces and six torques: strength.csv, strength.png",
            "pick_and_place_box --out results/box_strength  until the end of the first phase that holds the object",
            "bottle_grasp --set pressure.steps.all.0=80e3 --slid 2",
        ),
        (
            *CONSOLE,
            *scenario(),
            option("--object", "model that is loaded (default: that of the task, or the first free one)", "NAME"),
            option(
                "--slid",
                "mm along the fingers by which it may slide (default: %(default)s)",
                "MM",
                number(1e3),
                default=5.0,
            ),
            option(
                "--turned",
                "degrees in the fingers by which it may turn (default: %(default)s)",
                "DEG",
                number(180),
                default=20.0,
            ),
            option(
                "--seconds",
                "in which a force grows to the sum of the normal forces (default: %(default)s)",
                "S",
                number(1e3),
                default=2.0,
            ),
            *EXECUTOR,
            out("results/grasp_strength"),
        ),
    ),
    Command(
        "grasp-trials",
        "pick and place with random poses, masses, frictions and sizes",
        (
            "--trials 200 --seed 1                                        200 trials of every scenario",
            "--scenario pick_and_place_delicate --trials 20 --json",
            "--scenario pick_and_place_box --seed 1 --trial 7             rerun one, with its recording",
        ),
        (
            *CONSOLE,
            count("--trials", "number of trials of each scenario", 20),
            SEED,
            option(
                "--scenario",
                "scenario; may be repeated (default: the shipped pick_and_place scenarios)",
                "NAME",
                scenario_name,
                action="append",
            ),
            option("--trial", "run this trial only; keep its scenario and recording", "K", whole(0)),
            RESUME,
            *EXECUTOR,
            out("results/grasp_trials"),
        ),
        _check_trials,
    ),
    Command(
        "recognition",
        "learn from random grasps to recognize the object held, and test it",
        ("--train 60 --test 50 --seed 1",),
        (
            *CONSOLE,
            option("scenario", "default: %(default)s", read=scenario_name, nargs="?", default="probing_grasp"),
            count("--train", "number of grasps of each shape for learning", 60, least=2),
            count("--test", "number of other grasps of each shape for testing", 50),
            SEED,
            *EXECUTOR,
            out("results/recognition"),
        ),
    ),
    Command(
        "contact-trials",
        "press a finger against random pegs; report errors of contact force and location",
        (
            "--trials 200 --seed 1",
            "--contacts results/contact_trials/contacts.npz    evaluate the contacts of an earlier run again",
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
                "--estimator",
                "estimator of force and location, or your own as MODULE:FUNCTION; may be repeated (default: contact)",
                "NAME",
                action="append",
            ),
            *EXECUTOR,
            option("--contacts", "contacts.npz of an earlier run: evaluate these, simulate none", "FILE", path),
            out("results/contact_trials"),
        ),
    ),
    Command(
        "place-sensors",
        "find the best sensors of a finger, and boundaries between its sections",
        (
            "--count 3",
            "--count 2 --recordings results/a/recording.nc results/b/recording.nc",
            "--count 8 --scenarios turned_box_grasp    fingers that leave their plane: kinds, numbers and paths",
        ),
        (
            *CONSOLE,
            option(
                "--count",
                "sections along each side of a finger; in space, sensors of a finger at most",
                "N",
                whole(1),
                required=True,
            ),
            option(
                "--estimator",
                "built-in, or your own as MODULE:FUNCTION (default: %(default)s)",
                "NAME",
                default="gaussian",
            ),
            option(
                "--scenarios", "scenarios to place sensors for (default: those of `evaluate`)", "A,B", scenario_list
            ),
            option(
                "--recordings",
                "recording.nc of runs to place sensors for, instead of scenarios",
                "FILE",
                path,
                nargs="+",
            ),
            option(
                "--sensors",
                "preset of sensor errors, or ideal (default: %(default)s)",
                "PRESET",
                preset,
                default="realistic",
            ),
            option(
                "--nominal-error",
                "by how much the nominal model is too stiff or too soft (default: %(default)g)",
                "PERCENT",
                number(100.0, is_most_allowed=False),
                default=10.0,
            ),
            option(
                "--contacts",
                "contacts.npz of `contact-trials`: also report errors of contact force and location",
                "FILE",
                path,
            ),
            SEED,
            out("results/place_sensors"),
        ),
        _check_place_sensors,
    ),
    Command(
        "tune",
        "find gains for the grip control of a gripper",
        ("                              tune the shipped gripper", "my_steps.yaml --evaluations 80"),
        (
            *CONSOLE,
            *scenario("tip_distance_steps"),
            count("--evaluations", "maximum number of simulations", 50, least=5),
            SCHEDULER,
        ),
    ),
    Command(
        "calibrate",
        "calibrate sensors and fingers from recordings of free bending",
        (
            "results/free_bending/recording.nc --out my_gripper.yaml",
            "log.csv --bench my_bench.yaml --scenario my_scenario.yaml --out my_gripper.yaml",
            "free.c3d --as my_recording.yaml --scenario my_scenario.yaml --out my_gripper.yaml",
        ),
        (
            *CONSOLE,
            option("recording", "a recording.nc that `soft-gripper run` wrote, or a log", read=path, nargs="+"),
            option("--bench", "YAML file that names the fields of a log, as for `live`", "FILE", path),
            DESCRIBED_AS,
            option("--scenario", "scenario with the fingers and sensors of a log", "NAME"),
            option(
                "--find",
                "look for an offset of the pressure sensor, a curvature of the response, too",
                nargs="+",
                choices=("pressure", "response"),
                default=(),
            ),
            option("--out", "YAML file for nominal.calibration", "FILE", path, required=True),
        ),
    ),
    Command(
        "identify",
        "fit parameters of a finger to hardware recordings",
        (
            "swing.csv --as mine.yaml --finger mine.urdf --free youngs_modulus relaxation_time --out fitted.urdf",
            "a.csv b.csv --test c.csv --as mine.yaml --finger mine.urdf --free youngs_modulus --out fitted.urdf",
            "rest.csv --as mine.yaml --finger mine.urdf --free tendon.slack tendon.stiffness --out fitted.urdf",
            "--test new.csv --as mine.yaml --finger fitted.urdf                    test a fitted finger, without a fit",
        ),
        (
            *CONSOLE,
            option("file", "recording to fit to; searched for here, then in the data folder", nargs="*"),
            DESCRIBED_AS,
            option(
                "--test",
                "held out for testing; alone: test without a fit",
                "FILE",
                nargs="+",
                default=[],
            ),
            option("--finger", "URDF with one finger, the initial guess of the fit", "FILE", required=True),
            option("--free", "parameters to fit, such as youngs_modulus", "KEY", nargs="+", default=[]),
            option("--out", "URDF to write; set-up, table and figures are named after it", "FILE", urdf),
            DATA,
            count("--starts", "number of random restarts; the best fit is kept", 1),
            SEED,
            *EXECUTOR,
        ),
    ),
    Command(
        "weigh",
        "estimate the load at the tip of an identified finger from recordings at rest",
        (
            "load.csv --as mine.yaml --finger fitted.urdf",
            "load_*.csv --as mine.yaml --finger fitted.urdf --window 10 --out results/loads",
        ),
        (
            *CONSOLE,
            *RECORDINGS,
            option("--finger", "URDF with the identified finger, without a load", "FILE", required=True),
            option("--tare", "recording of much the same motion without a load, to cancel errors of the model", "FILE"),
            option("--window", "span of an estimate (default: %(default)s)", "SECONDS", number(1e6), default=30.0),
            DATA,
            out("results/weigh"),
        ),
    ),
    Command(
        "replay",
        "estimate shapes from hardware recordings and compare them with motion capture",
        (
            "trial_1.txt trial_2.txt --as two_segment_arm --estimator arcs gaussian",
            "trial_*.txt --as two_segment_arm --html animation.html",
        ),
        (
            *CONSOLE,
            *RECORDINGS,
            option("--fit", "recordings to fit to (default: all but the one estimated)", "FILE", nargs="+"),
            option(
                "--estimator", "built-in, or your own as MODULE:FUNCTION (default: all built-in)", "NAME", nargs="+"
            ),
            DATA,
            out("results/replay"),
            flag("--meshcat", "show it in a browser, and wait when it ends"),
            HOST,
            HTML,
        ),
    ),
    Command(
        "hardware",
        "identify and replay the published hardware recordings",
        ("--data ~/recordings",),
        (*CONSOLE, DATA, out("results/hardware"), *EXECUTOR),
    ),
    Command(
        "benchmark",
        "score estimators of shape, force, location, load and held objects, with fixed splits",
        (
            "                                           simulated contacts and grasps, which ship",
            "--data ~/recordings --estimator mine:estimator    recorded hardware too, and your own estimator",
            "--compare benchmark.json theirs.json",
        ),
        (
            *CONSOLE,
            DATA,
            option("--estimator", "your own estimator, beside the baselines", "MODULE:FUNCTION"),
            option("--compare", "print results files beside each other instead", "FILE", path, nargs="+", default=[]),
            option("--out", "file to write (default: %(default)s)", "FILE", json_file, default=Path("benchmark.json")),
        ),
    ),
    Command("list", "list the shipped scenarios", ("--json",), CONSOLE),
    Command(
        "show",
        "print a resolved scenario, and optionally draw its block diagram",
        ("box_grasp                            print all fields as YAML", "box_grasp --graphviz blocks.svg"),
        (*scenario(), option("--graphviz", "write the block diagram (.dot, .svg, .png or .pdf)", "FILE", path)),
    ),
    Command(
        "export",
        "write a scenario for another simulator, with a loader that runs it there",
        (
            "box_grasp --out results/box_mujoco    scenario.xml (MJCF), meshes, commands.csv, run_mjcf.py",
            "my_scenario.yaml --to sdf --out there    SDFormat, for Gazebo and others; without the pressures",
        ),
        (
            *CONSOLE,
            *scenario(),
            option("--to", "format (default: %(default)s)", choices=("mjcf", "sdf"), default="mjcf"),
            option("--time-step", "time step of the MJCF (default: that of the scenario)", "S", number(0.1)),
            option("--out", "folder for the files", "DIR", path, required=True),
        ),
    ),
    Command(
        "expand",
        "expand the <finger>s of a URDF to links, joints and springs",
        ("package://soft_gripper/grippers/two_finger.urdf -o plain.urdf", "mine.urdf --segments 24 -o plain.urdf"),
        (
            option("file", "URDF file, a path or a package://soft_gripper/... URI"),
            option("--segments", "number of segments of each finger (default: as in the file)", "N", whole(1)),
            option("-o --out", "file to write (default: standard output)", "FILE", path),
        ),
    ),
    Command("doctor", "check the installation", ("", "--json"), CONSOLE),
)


class _Parser(argparse.ArgumentParser):
    """Reports a usage error in one line, and quotes the input shortened, as all other messages do."""

    def error(self, message: str) -> NoReturn:
        where = self.prog.replace(f"{PROGRAM} ", f"{PROGRAM}: ")
        hint = f"`{PROGRAM} COMMAND --help` lists options"
        self.exit(ExitCode.REFUSED, f"{where}: {in_one_line(shortened(message))}; {hint}\n")


def command_parser() -> argparse.ArgumentParser:
    """The parser of all commands; its results hold the Command as `command`, and values as text."""
    codes = ", ".join(f"{code.value} {code.name.lower().replace('_', ' ')}" for code in ExitCode)
    parser = _Parser(
        prog=PROGRAM,
        description="Soft, sensing grippers simulated in Drake.",
        epilog=f"`{PROGRAM} COMMAND --help` has examples. Exit codes: {codes}.",
    )
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {version(PROGRAM)}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)
    for command in COMMANDS:
        examples = (f"  {PROGRAM} {command.name} {example}".rstrip() for example in command.examples)
        own = subparsers.add_parser(
            command.name,
            help=command.does,
            description=f"{command.does[0].upper()}{command.does[1:]}.",
            epilog="\n".join(["examples:", *examples]),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        own.set_defaults(command=command)
        for each in command.options:
            _complete(own.add_argument(*each.names, **each.settings), each)
    _add_completion(parser)
    return parser


_SCENARIOS = "_soft_gripper_scenarios"


def _add_completion(parser: argparse.ArgumentParser) -> None:
    names = " ".join(scenario_names())
    preamble = {
        "bash": f'{_SCENARIOS}() {{ compgen -W "{names}" -- "$1"; compgen -f -- "$1"; }}',
        "zsh": f"{_SCENARIOS}() {{ compadd {names}; _files; }}",
    }
    help_ = "print the shell completion script and exit"
    shtab.add_argument_to(parser, "--print-completion", help=help_, preamble=preamble)


def _complete(action: argparse.Action, of: Option) -> None:
    """Sets how a shell completes an option."""
    if of.read is scenario_name:
        action.complete = {"bash": _SCENARIOS, "zsh": _SCENARIOS}  # type: ignore[attr-defined]
    elif of.read in (path, urdf):
        action.complete = shtab.FILE  # type: ignore[attr-defined]


def parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """The parsed options of a command line, with the Command as `command`.

    Raises:
        InputError: naming command, option and value, if a value is wrong.
        SystemExit: after --help, and after an error reported by argparse.
    """
    options = command_parser().parse_args(arguments)
    command: Command = options.command
    for each in command.options:
        _read(options, command, each)
    command.check(options)
    return options


def _read(options: argparse.Namespace, command: Command, of: Option) -> None:
    """Replaces the text of an option with its value."""
    name = of.names[-1]
    key = of.settings.get("dest", name.lstrip("-").replace("-", "_"))
    given = getattr(options, key)
    texts = given if isinstance(given, list) else [given]
    if of.read is None or not all(isinstance(text, str) for text in texts):
        return  # a default
    values = []
    for text in texts:
        try:
            values.append(of.read(text))
        except InputError:
            raise
        except ValueError as error:
            raise InputError(command.name, name, text, str(error)) from None
    setattr(options, key, values if isinstance(given, list) else values[0])
