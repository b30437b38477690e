"""Commands of this extra, as the command line lists them."""

from pathlib import Path

from soft_gripper.commands.options import (
    CONSOLE,
    DATA,
    Command,
    Group,
    json_file,
    option,
    path,
)

COMMANDS = (
    Command(
        "benchmark",
        "score estimators of shape, force, location, load and held objects, with fixed splits",
        (
            "                                           simulated contacts and grasps, which ship",
            "--data ~/recordings --estimator mine:estimator    recorded hardware too, and your own estimator",
            "--estimator mine:estimator --submit mine.json     what it states of every sample, to be scored by others",
            "--score theirs.json --data ~/recordings           scores of such a file, without its code",
            "--compare benchmark.json theirs.json",
        ),
        (
            *CONSOLE,
            DATA,
            option("--estimator", "your own estimator, beside the baselines", "MODULE:FUNCTION"),
            option("--submit", "write what --estimator states of every test sample, too", "FILE", json_file),
            option("--score", "score submissions of others instead", "FILE", path, nargs="+", default=[]),
            option("--compare", "print results files beside each other instead", "FILE", path, nargs="+", default=[]),
            option("--out", "file to write (default: %(default)s)", "FILE", json_file, default=Path("benchmark.json")),
        ),
        package=__name__,
        group=Group.STUDY,
    ),
)
