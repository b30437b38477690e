"""Worker processes: what comes of calls, of processes that die or grow, and of those whose parent has gone."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from refusals import refused
from waiting import LONG, wait_until

from soft_gripper.child_processes import environment
from soft_gripper.errors import InputError, WorkerDiedError
from soft_gripper.extras.sweeps import executor as worker_processes
from soft_gripper.extras.sweeps.executor import MainScriptError, WorkerProcesses, open_executor

TESTS = Path(__file__).parents[2]
PATHS = [str(TESTS), str(TESTS / "helpers")]

PARENT = """
import sys, time
sys.path += {paths!r}
from extras.sweeps.test_worker_processes import write_and_sleep
from soft_gripper.extras.sweeps.executor import WorkerProcesses
if __name__ == "__main__":
    with WorkerProcesses(2) as executor:
        calls = [executor.submit(write_and_sleep, {folder!r}) for _ in range(3)]
        calls[0].result()
"""


def pid(_: int) -> int:
    return os.getpid()


def die_at(number: int, fatal: int) -> int:
    if number == fatal:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def die_once(file: str) -> str:
    if not Path(file).exists():
        Path(file).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "made"


def fail(_: int) -> None:
    raise InputError("here", "field", 1, "would be 2")


def hold(megabytes: int) -> int:
    held.append(os.urandom(1000) * 1000 * megabytes)
    return os.getpid()


held: list[bytes] = []


def temporary_folder() -> tuple[str, bool]:
    return tempfile.gettempdir(), signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def write_and_sleep(folder: str) -> None:
    (Path(folder) / f"{os.getpid()}.txt").write_text(tempfile.gettempdir())
    time.sleep(2 * LONG)


@pytest.fixture(scope="module")
def executor():
    with WorkerProcesses(2) as processes:
        yield processes


def test_a_temporary_folder_too_deep_for_sockets_is_refused(monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", "/tmp/" + 66 * "d")
    with refused("TMPDIR"):
        WorkerProcesses(1)


def test_calls_are_made_in_other_processes_and_errors_arrive(executor):
    found = {executor.submit(pid, i).result() for i in range(4)}
    assert os.getpid() not in found
    with pytest.raises(InputError, match="here: field = 1: would be 2"):
        executor.submit(fail, 1).result()


@pytest.mark.slow
def test_a_terminal_that_closes_leaves_no_complaint(tmp_path):
    folder = tmp_path / "begun"
    folder.mkdir()
    script = "import signal, sys; signal.signal(signal.SIGHUP, lambda *_: sys.exit(129))" + PARENT
    command = [sys.executable, "-c", script.format(paths=PATHS, folder=str(folder))]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        wait_until(lambda: list(folder.iterdir()))
        os.killpg(process.pid, signal.SIGHUP)  # to all, as the kernel does
        _, said = process.communicate(timeout=LONG)
    assert (process.returncode, said) == (129, "")


@pytest.mark.slow
def test_processes_run_no_module_of_the_current_folder_and_one_thread(tmp_path):
    for name in ("multiprocessing", "pickle", "resource", "numpy"):
        (tmp_path / f"{name}.py").write_text("open('was_run', 'w')")
    script = tmp_path / "elsewhere" / "script.py"
    script.parent.mkdir()
    script.write_text(
        "import os\nfrom soft_gripper.extras.sweeps.executor import open_executor\n"
        "def threads(): return os.environ.get('OPENBLAS_NUM_THREADS')\n"
        'if __name__ == "__main__":\n'
        "    with open_executor(1) as executor: print(executor.submit(threads).result(), threads())\n"
    )
    free = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    found = subprocess.run(
        [sys.executable, script], cwd=tmp_path, check=True, env=free, stdout=subprocess.PIPE, text=True
    )
    assert not (tmp_path / "was_run").exists()
    assert found.stdout.split() == ["1", "None"]


def test_a_process_that_dies_takes_no_other_call_with_it(executor, caplog):
    calls = [executor.submit(die_at, i, 3) for i in range(8)]
    assert [call.result() for call in calls if call is not calls[3]] == [0, 1, 2, 4, 5, 6, 7]
    with pytest.raises(WorkerDiedError, match=r"2 times at die_at\(3, 3\)"):
        calls[3].result()
    assert [record.message.count("die_at(3, 3)") for record in caplog.records] == [1, 1]


def test_a_call_whose_process_died_by_chance_is_made_again(executor, tmp_path):
    assert executor.submit(die_once, str(tmp_path / "died")).result() == "made"


@pytest.mark.slow
def test_a_process_that_has_grown_makes_way_for_another(monkeypatch):
    monkeypatch.setattr(worker_processes, "GROWTH", 100 * 2**20)
    with WorkerProcesses(1) as executor:
        pids = [executor.submit(hold, 60).result() for _ in range(6)]
    assert [pids.count(one) for one in dict.fromkeys(pids)] == [3, 3]


def test_temporary_files_lie_in_a_folder_that_goes_and_ctrl_c_is_the_parents():
    with WorkerProcesses(1) as executor:
        folder, ignores = executor.submit(temporary_folder).result()
        assert Path(folder).is_dir()
        assert ignores
    assert not Path(folder).exists()


def test_an_exception_ends_the_calls_at_once(tmp_path):
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted(tmp_path)
    assert time.monotonic() - begun < 30
    assert [is_alive(int(file.stem)) for file in tmp_path.iterdir()] == [False]


def interrupted(folder: Path) -> None:
    with WorkerProcesses(1) as executor:
        for _ in range(3):
            executor.submit(write_and_sleep, str(folder))
        while not list(folder.iterdir()):
            time.sleep(0.05)
        raise KeyboardInterrupt


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_processes_end_when_their_parent_has_gone(tmp_path, number):
    (tmp_path / "begun").mkdir()
    script = tmp_path / "parent.py"
    script.write_text(PARENT.format(paths=PATHS, folder=str(tmp_path / "begun")))
    with subprocess.Popen([sys.executable, script]) as parent:
        try:
            wait_until(lambda: len(written(tmp_path / "begun")) == 2)
        finally:
            parent.send_signal(number)
    files = written(tmp_path / "begun")
    wait_until(lambda: not any(is_alive(int(file.stem)) for file in files))
    assert [Path(file.read_text()).exists() for file in files] == [False, False]


def written(folder: Path) -> list[Path]:
    """The files that are not empty."""
    return [file for file in folder.iterdir() if file.stat().st_size]


def is_alive(process: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[:1]
    except FileNotFoundError:
        return False


UNGUARDED = """
import sys
sys.path += {paths!r}
from extras.sweeps.test_worker_processes import pid
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import run_study
print("begins", flush=True)
with open_executor(1) as executor:
    run_study(executor, pid, {{i: (i,) for i in range(20)}}, print)
"""


@pytest.mark.slow
def test_a_script_without_a_guard_is_told_so(tmp_path):
    """And the calls that are left are not tried."""
    script = tmp_path / "own_script.py"
    script.write_text(UNGUARDED.format(paths=PATHS))
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=LONG, check=False)
    assert ended.returncode == 1
    said = ended.stderr.strip().splitlines()[-1]
    assert str(script) in said
    assert '__name__ == "__main__"' in said
    assert "out of memory" not in ended.stderr
    assert ended.stdout.count("begins") <= 4


@pytest.mark.parametrize("guard", ["", 'if __name__ == "__main__": '])
def test_a_script_on_standard_input_is_refused_before_any_call(guard):
    """No process could import it."""
    script = (
        f"from soft_gripper.extras.sweeps.executor import open_executor\n{guard}print(open_executor(1).__enter__())"
    )
    ended = subprocess.run(
        [sys.executable, "-"], input=script, capture_output=True, text=True, timeout=LONG, check=False
    )
    assert (ended.returncode, ended.stdout) == (1, "")
    said = ended.stderr.strip().splitlines()[-1]
    assert "__main__ = '<stdin>': every process imports it: save it as a file" in said
    assert '__name__ == "__main__"' in said


def test_a_function_that_processes_cannot_import_is_named():
    """Such as one that is defined in a notebook."""
    with pytest.raises(MainScriptError, match=r"__main__ = 'mine\(3\)': import it from a module"):
        worker_processes.make("mine(3)", b"c__main__\nmine\n.")


@pytest.mark.parametrize("jobs", [0, -1, "two", 1.5])
def test_a_number_of_processes(jobs):
    with pytest.raises(InputError) as caught, open_executor(jobs):
        pass
    assert caught.value.field == "jobs"


def test_variables_of_processes_leave_those_of_the_user(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    with environment({"OMP_NUM_THREADS": "1", "OF_A_PROCESS": "1"}):
        assert os.environ["OMP_NUM_THREADS"] == "1"
    assert (os.environ["OMP_NUM_THREADS"], os.environ.get("OF_A_PROCESS")) == ("3", None)
