"""Declares the commands of this extra; each calls `run(options)` in the module of its name."""

from soft_gripper.commands.options import HOST, MCAP, Command, Group, flag, number, option, path, scenario

COMMANDS = (
    Command(
        "live",
        "estimate from the sensors of hardware, in real time, and command it",
        (
            "tip_distance_steps --bench bench.yaml --zero 2    readings and commands as bench.yaml describes",
            "tip_distance_steps --bench bench.yaml --page      the same in a browser, to look at",
            "my_scenario.yaml --bench bench.yaml --source udp://:6000 --out results/monday",
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
            flag("--json", "print every result as a line of JSON, instead of a status line", dest="json_lines"),
            flag("--fast", "use the readings of a file as fast as possible"),
            flag("--page", "show estimates, contacts and the counts of readings in a browser; zero and record there"),
            HOST,
            option("--out", "folder for a recording of every signal; with --page, for its recordings", "DIR", path),
            MCAP,
        ),
        package=__name__,
        group=Group.HARDWARE,
    ),
)
