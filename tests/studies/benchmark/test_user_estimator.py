"""A user's estimator has a process of its own, in which a cheat finds no answer, and whose end is one line."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from benchmark_folders import write_force_folder
from study_line import study_line

from soft_gripper.errors import InputError
from studies.benchmark import tasks, user_estimator
from studies.benchmark.benchmark_task import Channel, Question, Recorded, read_tests, read_training
from studies.benchmark.measured_force import force_tasks
from studies.commands import benchmark

CHEATS = Path(__file__).with_name("benchmark_cheats.py")


@pytest.fixture
def score(tmp_path, monkeypatch):
    """The mean errors of a cheat in the regions of a task, and those of the mean of the training set."""
    shutil.copy(CHEATS, tmp_path / "cheats.py")
    data = tmp_path / "cheated"
    write_force_folder(data)
    monkeypatch.setenv("SOFT_GRIPPER_DATA", str(data))
    monkeypatch.setattr(sys, "argv", ["soft-gripper", "benchmark", "--data", str(data)])
    for name, value in {"baselines": {}, "ours": {}, "figure": None, "save_figure": None}.items():
        monkeypatch.setattr(benchmark, name, lambda *_, value=value: value)
    monkeypatch.chdir(data)

    def score(cheat, name):
        (task,) = [task for task in (*tasks.TASKS, *force_tasks(data)) if task.name == name]
        monkeypatch.setattr(benchmark, "TASKS", [task])
        monkeypatch.setattr(benchmark, "force_tasks", lambda data: [])
        file = tmp_path / "scores.json"
        outcome = study_line("benchmark", f"{tmp_path / 'cheats.py'}:{cheat}", "--out", file)
        assert outcome.code == 0, outcome.err
        train, tested = read_training(task, task.folder, tmp_path / "copies"), read_tests(task, task.folder)
        mean = np.vstack([recorded.outputs for recorded in train]).mean(axis=0)
        errors = [np.linalg.norm(of[0].outputs - mean, axis=1).mean() for of in tested.values()]
        return [row["mean"] for row in json.loads(file.read_text())["scores"]], errors, outcome.err

    return score


@pytest.mark.parametrize(
    ("cheat", "task"),
    [
        ("shipped", "contact_tip"),
        ("copied", "contact_force"),
        ("named", "force_scale"),
        ("told", "force_scale"),
        ("remembering", "contact_tip"),
    ],
)
def test_a_cheat_finds_no_answer(score, cheat, task):
    errors, of_mean, said = score(cheat, task)
    if "no Landlock" in said:
        pytest.skip(said)
    assert errors == pytest.approx(of_mean)


def test_a_system_that_cannot_hide_files_is_named(score, monkeypatch):
    open_to_all = user_estimator._CHILD_SCRIPT.replace("= hide(parent.recv())", "= not parent.recv()")
    monkeypatch.setattr(user_estimator, "_CHILD_SCRIPT", open_to_all)
    errors, _, said = score("shipped", "contact_tip")
    assert said.endswith("cheats.py:shipped could read the tests: this system has no Landlock\n")
    assert errors == [0, 0, 0]


QUESTION = Question("twin", (Channel("a", "V"),), (Channel("b", "V"),), None, False)
TRAIN = [Recorded(np.ones((3, 1)), np.ones((3, 1)))]
INPUTS = np.arange(4.0)[:, None]


@pytest.fixture
def asked(tmp_path):
    """What an estimator with this body states of INPUTS."""

    def asked(body, hidden=()):
        lines = "".join(f"    {line}\n" for line in body.splitlines())
        (tmp_path / "mine.py").write_text(f"import gc, os, signal, sys, time\n\ndef estimator(task, train):\n{lines}")
        with user_estimator.user_estimator(f"{tmp_path / 'mine.py'}:estimator", hidden) as (estimator, _):
            return estimator(QUESTION, TRAIN)(INPUTS)

    return asked


def test_mean_and_standard_deviation_come_back_to_the_last_digit(asked):
    mean, std = asked("return lambda inputs: (inputs / 3, train[0].outputs[:1] * inputs / 7)")
    np.testing.assert_array_equal(mean, INPUTS / 3)
    np.testing.assert_array_equal(std, INPUTS / 7)


CONNECTION = "next(each for each in gc.get_objects() if type(each).__name__ == 'Connection' and each.writable)"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return lambda inputs: 1 / 0", "failed on twin = 'ZeroDivisionError: division by zero'"),
        ("raise ValueError('two\\nlines')", "failed on twin = 'ValueError: two'"),
        ("raise PermissionError('beside a recording')", "folders of recordings cannot be read here"),
        ("return lambda inputs: sys.exit(3)", "sys.exit(3) was called"),
        ("return lambda inputs: os._exit(3)", "its process ended with code 3"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "its process was ended: Segmentation fault"),
        ("os.fork() or time.sleep(9)\nos._exit(4)", "its process ended with code 4"),
        ("os.closerange(3, 99)\ntime.sleep(9)", "its process closed the connection"),
        ("return input", "EOFError"),
        ("return None", "returned = 'NoneType': must be a function predict(inputs)"),
        ("return lambda inputs: object()", "mean on twin = 'object': must be numbers"),
        ("return lambda inputs: inputs[1:]", "shape of mean on twin"),
        ("return lambda inputs: 0 * inputs + 1e200", "mean on twin = 1e+200: must be finite, and below 1e+09"),
        ("return lambda inputs: inputs * float('nan')", "mean on twin = nan: must be finite"),
        ("raise KeyboardInterrupt", "failed on twin = 'KeyboardInterrupt"),
        (f"{CONNECTION}.send_bytes(b'[' * 10**5)", "its process answered with something else"),
        (f"{CONNECTION}.send_bytes(b'{{\"mistake\": 3}}')", "its process answered with something else"),
        (f"{CONNECTION}.send(3)", "its process answered with something else"),
    ],
)
def test_whatever_an_estimator_does_is_one_line(asked, body, said):
    with pytest.raises(InputError) as caught:
        asked(body)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


HIDE = """
import subprocess, sys
from pathlib import Path
from studies.benchmark.hidden_folders import hide
hide([Path(name) for name in ("hidden", "hidden/folder", "beside/file")]) or sys.exit(9)
for name in "hidden/file hidden/folder/file beside/file to_file to_folder/file other/file beside/two".split():
    ended = subprocess.run(["cat", name], capture_output=True, text=True)
    print(name, ended.stdout or ended.stderr.rpartition(": ")[2].strip())
    if subprocess.run(["sh", "-c", ': >> "$0"', name], stderr=subprocess.DEVNULL).returncode == 0:
        print("written:" + name, "")
"""


def test_hidden_files_can_be_neither_read_nor_written_and_others_can(tmp_path):
    for name in ("hidden/file", "hidden/folder/file", "beside/file", "other/file", "beside/two"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("read")
    (tmp_path / "to_file").symlink_to("hidden/file")
    (tmp_path / "to_folder").symlink_to("hidden")
    ended = subprocess.run([sys.executable, "-c", HIDE], cwd=tmp_path, capture_output=True, text=True)
    if ended.returncode == 9:
        pytest.skip("the system has no Landlock")
    assert ended.stderr == ""
    found = dict(line.split(" ", 1) for line in ended.stdout.splitlines())
    assert {name for name, said in found.items() if said == "read"} == {"other/file", "beside/two"}
    assert {name for name in found if name.startswith("written:")} == {"written:other/file", "written:beside/two"}
    assert {said for said in found.values() if said not in ("read", "")} == {"Permission denied"}
