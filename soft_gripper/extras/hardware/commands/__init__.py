"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import (
    CONSOLE,
    HOST,
    HTML,
    SEED,
    SET,
    Command,
    Group,
    amount,
    count,
    flag,
    folder_option,
    number,
    option,
    path,
    urdf,
)
from soft_gripper.extras.sweeps.commands import EXECUTOR

DESCRIBED_AS = option("--as", "description of the data: shipped, or a YAML file", "NAME", dest="described_as")
RECORDINGS = (option("file", "recording; searched for here, then in the data folder", nargs="+"), DESCRIBED_AS)
DATA = option("--data", "data folder (default: $SOFT_GRIPPER_DATA)", "DIR", path)
BENCH = option("--bench", "YAML file that names the fields of a log, as for `live`", "FILE", path)
LOGGED = option("--scenario", "scenario with the fingers and sensors of a log", "NAME")
COMMANDS = (
    Command(
        "calibrate",
        "calibrate sensors and fingers from recordings of free bending and measured forces",
        (
            "results/free_bending/recording.nc --out my_gripper.yaml",
            "log.csv --bench my_bench.yaml --scenario my_scenario.yaml --out my_gripper.yaml",
            "free.c3d --as my_recording.yaml --scenario my_scenario.yaml --out my_gripper.yaml",
        ),
        (
            *CONSOLE,
            option("recording", "a recording.nc that `soft-gripper run` wrote, or a log", read=path, nargs="+"),
            BENCH,
            DESCRIBED_AS,
            LOGGED,
            option(
                "--find",
                "look for an offset of the pressure sensor, a curvature of the response, a variation of the bend, too",
                nargs="+",
                choices=("pressure", "response", "variation"),
                default=(),
            ),
            option("--out", "YAML file for nominal.calibration", "FILE", path, required=True),
        ),
        package=__name__,
        group=Group.HARDWARE,
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
            option("--test", "held out for testing; alone: test without a fit", "FILE", nargs="+", default=[]),
            option("--finger", "URDF with one finger, the initial guess of the fit", "FILE", required=True),
            option("--free", "parameters to fit, such as youngs_modulus", "KEY", nargs="+", default=[]),
            option("--out", "URDF to write; set-up, table and figures are named after it", "FILE", urdf),
            DATA,
            count("--starts", "number of random restarts; the best fit is kept", 1),
            SEED,
            *EXECUTOR,
        ),
        package=__name__,
        group=Group.HARDWARE,
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
            amount("--window", "span of an estimate", "SECONDS", 1e6, 30.0),
            DATA,
            folder_option("results/weigh"),
        ),
        package=__name__,
        group=Group.HARDWARE,
    ),
    Command(
        "replay",
        "estimate from hardware recordings and compare with motion capture, or with a measured force",
        (
            "trial_1.txt trial_2.txt --as two_segment_arm --estimator arcs gaussian",
            "trial_*.txt --as two_segment_arm --html animation.html",
            "press.csv --bench my_bench.yaml --scenario my_finger.yaml      a finger that presses on a scale",
            "new.txt --fit trial_1.txt trial_2.txt --as two_segment_arm --zero 2              wires were set anew",
        ),
        (
            *CONSOLE,
            *RECORDINGS,
            LOGGED,
            SET,
            BENCH,
            option("--fit", "recordings to fit to (default: all but the one estimated)", "FILE", nargs="+"),
            option(
                "--estimator",
                "built-in, or your own as MODULE:FUNCTION (default: all built-in, or that of the scenario)",
                "NAME",
                nargs="+",
            ),
            option(
                "--zero",
                "find offsets again in the first seconds: of an arm's wires from its pose, of a finger that is free",
                "SECONDS",
                number(3600.0),
                default=0.0,
            ),
            DATA,
            folder_option("results/replay"),
            flag("--meshcat", "show it in a browser, and wait when it ends"),
            HOST,
            HTML,
        ),
        package=__name__,
        group=Group.HARDWARE,
    ),
)
