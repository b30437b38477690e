"""A progress bar that counts jobs, and tells on Ctrl-C what remains of them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from soft_gripper.commands.console import Console


@contextmanager
def count_jobs(console: Console, total: int, description: str, interruption_note: str) -> Iterator[Callable[..., None]]:
    """Counts jobs; call the yielded function after each job, with True if it succeeded.

    On Ctrl-C, prints how many have ended, and `interruption_note`, a note on which results remain.
    """
    successes: list[bool] = []
    with console.counter(total, description) as bar:

        def count_job(succeeded: bool = True) -> None:
            successes.append(succeeded)
            if not all(successes):
                bar.set_postfix_str(f"{successes.count(False)} failed")
            bar.update()

        try:
            yield count_job
        except KeyboardInterrupt:
            bar.close()
            print(f"\n{len(successes)} of {total} {description} ended; {interruption_note}")
            raise
