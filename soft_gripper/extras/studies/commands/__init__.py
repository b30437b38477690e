"""Commands of this extra, as the command line lists them."""

from soft_gripper.commands.options import (
    CONSOLE,
    EXECUTOR,
    RESUME,
    SEED,
    Command,
    Group,
    count,
    number,
    option,
    out,
    path,
)

COMMANDS = (
    Command(
        "study contact-trials",
        "press a finger against random pegs; report errors of contact force and location",
        (
            "--trials 200 --seed 1",
            "--contacts results/contact_trials/contacts.nc    evaluate the contacts of an earlier run again",
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
            option("--contacts", "contacts.nc of an earlier run: evaluate these, simulate none", "FILE", path),
            out("results/contact_trials"),
        ),
        package=__name__,
        group=Group.STUDY,
    ),
    Command(
        "study contact-coverage",
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
        group=Group.STUDY,
    ),
    Command(
        "study robustness",
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
        group=Group.STUDY,
    ),
)
