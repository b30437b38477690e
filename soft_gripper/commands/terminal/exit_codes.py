"""How a command ends, for shells and scripts."""

from enum import IntEnum


class ExitCode(IntEnum):
    """The exit codes of all commands."""

    DONE = 0
    FAILED = 1  # a task or a claim failed
    REFUSED = 2  # a mistake in the input, or a file that cannot be written
    INTERRUPTED = 130  # Ctrl-C
    READER_GONE = 141  # whoever read the output is gone, as a shell has it
