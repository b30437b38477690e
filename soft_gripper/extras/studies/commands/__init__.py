"""Commands of this extra, as the command line lists them."""

from soft_gripper.commands.options import (
    CONSOLE,
    EXECUTOR,
    SEED,
    Command,
    count,
    number,
    option,
    out,
    path,
)

COMMANDS = (
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
        package=__name__,
    ),
)
