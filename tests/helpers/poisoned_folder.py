"""A folder of files that must not run or be read, and the commands that are run in it."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.metadata import packages_distributions
from pathlib import Path

RAN = "ran.txt"  # the names of the modules that ran
SETTINGS = "no settings of the user"  # a line at which matplotlib prints a warning that names the file
# As an installed command runs, which worker processes import. Commands that take long run in forks of the first one,
# which have all that is imported, and end after a time. Semaphores are as in Python 3.14, which starts a process for
# them.
SCRIPT = """
import json, multiprocessing, os, signal, sys
from pathlib import Path

def call(words):
    from soft_gripper.commands import main
    sys.argv[1:] = words
    return main()

def call_in_fork(words):
    if not (child := os.fork()):
        signal.alarm(seconds)
        sys.exit(call(words))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

if __name__ == "__main__":
    multiprocessing.set_start_method("forkserver")
    lines, seconds = json.loads(sys.argv[1]), int(sys.argv[2])
    ran, found = Path("ran.txt"), {}
    for name, words in lines.items():
        code = call_in_fork(words) if found and seconds else call(words)
        found[name] = code, ran.read_text().split() if ran.exists() else []
        ran.unlink(missing_ok=True)
    print("FOUND", json.dumps(found))
"""


def poison(folder: Path) -> None:
    """Writes a module named like each of the standard library and of all packages, and a `matplotlibrc`."""
    names = {*sys.stdlib_module_names, *packages_distributions(), "sitecustomize", "usercustomize", "conftest"}
    for name in filter(str.isidentifier, names):
        (folder / f"{name}.py").write_text(f"open({str(folder / RAN)!r}, 'a').write('{name}\\n')")
    (folder / "matplotlibrc").write_text(SETTINGS)


def run_in(folder: Path, lines: Mapping[str, Sequence[str]], seconds: int = 0) -> dict[str, tuple[int, list[str]]]:
    """Exit codes of commands, and modules of the folder that each ran; -14 is that of one that takes more `seconds`."""
    script = folder / "bin" / "soft-gripper"
    script.parent.mkdir(exist_ok=True)
    script.write_text(SCRIPT)
    command = [sys.executable, script, json.dumps(lines), str(seconds)]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert "matplotlibrc" not in ended.stdout + ended.stderr
    found: dict[str, tuple[int, list[str]]] = json.loads(ended.stdout.rpartition("FOUND ")[2])
    print(ended.stdout, ended.stderr)  # shown where a test fails
    return found
