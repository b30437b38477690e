"""Files and options of strangers, from end to end: refused in a line that names file and field before anything runs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import soft_gripper

from soft_gripper.commands import replay
from soft_gripper.diagrams.view import meshcat_view as meshcats
from soft_gripper.errors import InputError
from soft_gripper.models import DIRECTORY

FINGER = (DIRECTORY / "grippers" / "finger.urdf").read_text()
LINK = '<robot name="r"><link name="l"><visual>{}</visual></link></robot>'
SDF = '<sdf version="1.7"><model name="m"><link name="l">{}</link></model></sdf>'
RING = "".join(
    f'<joint name="{parent}{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
    '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    for parent, child in ("ab", "ba")
)
SCENARIOS = {
    "arm: {1: 2}": "arm = 1",
    "2001-01-01: 3": "key = ",
    "? \n: 3": "key = None",
    "sensor: !foo {sections: 2}": "sensor = '!foo'",
    "sensor: {seed: " + "9" * 5000 + "}": "file = 's.yaml'",
    "gravity: " + "[" * 3000 + "]" * 3000: "depth = 41",
    "task: {X_OG: {translation: [.inf, 0, 0]}}": "task.X_OG.translation[0] = inf",
    "sensor: {response: [[1, 0], [1.000000000000001, 1]]}": "sensor.response = ",
    "plant_config: {time_step: 1.0e-12}": "plant_config.time_step = 1e-12",
}
MODELS = {
    "{name: f, file: finger.urdf, X_PC: {base_frame: here}}": "models[0].X_PC.base_frame = 'here'",
    "{name: f, file: finger.urdf, X_PC: {rotation: !AngleAxis {angle_deg: 3, axis: [0, 0, 0]}}}": "rotation = '!Angle",
    "{name: f, file: finger.urdf, X_PC: {rotation: !Uniform {}}}": "rotation = '!Uniform'",
    '{name: f, file: "a\\0b.urdf"}': "models[0].file = ",
    "{name: f, file: " + "n" * 300 + ".urdf}": "models[0]: file = ",
    "{name: f, file: loop.urdf}": "models[0]: file = ",
    "{name: f, file: pipe.urdf}": "models[0]: file = ",
    "{name: a.b, file: finger.urdf}": "models[0].name = 'a.b'",
    "{name: " + "n" * 300 + ", file: finger.urdf}": "models[0].name = ",
    "{name: f, file: package://soft_gripper/../x.urdf}": "model: file = 'package://soft_gripper/../x.urdf'",
}
OBJECTS = {
    "bare.urdf": ('<robot name="r"/>', "models[1]: file = "),
    "zero.urdf": (LINK.format('<geometry><box size="0 1 1"/></geometry>'), "link 'l': box.size = '0 1 1'"),
    "nan.urdf": (LINK.format('<geometry><box size="nan 1 1"/></geometry>'), "link 'l': box.size = 'nan 1 1'"),
    "words.urdf": (LINK.format('<origin xyz="a b"/>'), "link 'l': origin.xyz = 'a b'"),
    "bomb.urdf": ('<!DOCTYPE r [<!ENTITY a "aa">]><robot name="&a;"/>', "bomb.urdf: DOCTYPE = 'r'"),
    "secret.sdf": ('<!DOCTYPE r [<!ENTITY a SYSTEM "s.yaml">]><sdf/>', "secret.sdf: DOCTYPE = 'r'"),
    "nan.sdf": (SDF.format("<inertial><inertia><ixx>nan</ixx></inertia></inertial>"), "link 'l': ixx = 'nan'"),
    "latin.sdf": (SDF.format("<!-- \xe9 -->"), "latin.sdf: file = 'latin.sdf': cannot be read: it is not a text file"),
    "ring.urdf": (
        f'<robot name="r"><link name="a"/><link name="b"/>{RING}</robot>',
        "joint 'ba': parent, child = 'b, a'",
    ),
}
FINGERS = {
    'length="0.12"': ('length="5e-324"', "body.length = 5e-324: "),
    'width="0.02"': ('width="1e308"', "base.width = 1e+308: "),
    'segments="12"': ('segments="2000"', "body.segments = 2000: "),
}
OPTIONS = {
    ("grasp-trials", "--trials", "0"): "--trials = '0'",
    ("grasp-trials", "--trials", "²"): "--trials = '²'",
    ("grasp-trials", "--trials", "٣"): "--trials = '٣'",
    ("grasp-trials", "--trials", "100000000000"): "--trials = '100000000000'",
    ("grasp-trials", "--jobs", "0"): "--jobs = '0'",
    ("grasp-trials", "--jobs", "100000"): "--jobs = '100000'",
    ("grasp-trials", "--seed", "-1"): "--seed = '-1'",
    ("grasp-trials", *(2 * ("--scenario", "pick_and_place_box"))): "--scenario = 'pick_and_place_box'",
    ("show", "free_bending", "--set", "models.²=1"): "--set: key = 'models.²'",
    ("show", "free_bending", "--set", ".".join("a" * 3000) + "=1"): "--set: key = ",
    ("show", "free_bending", "--set", "sensor.seed=" + "9" * 5000): "--set: sensor.seed = ",
    ("show", "n" * 300 + ".yaml"): "scenario = ",
}


@pytest.fixture(autouse=True)
def _work_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("finger.urdf").write_text(FINGER)
    Path("loop.urdf").symlink_to("loop.urdf")
    os.mkfifo("pipe.urdf")


def refusal(*arguments: str) -> str:
    outcome = soft_gripper(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.startswith("soft-gripper: ")
    assert outcome.err.count("\n") == 1
    assert len(outcome.err) < 1000
    assert not Path("results").exists()
    return outcome.err


@pytest.mark.parametrize("text", SCENARIOS, ids=lambda text: text[:30])
def test_scenarios(text: str) -> None:
    Path("s.yaml").write_text("models: [{name: f, file: finger.urdf}]\n" + text)
    line = refusal("run", "s.yaml")
    assert "s.yaml: " in line
    assert SCENARIOS[text] in line


@pytest.mark.parametrize("model", MODELS, ids=lambda text: text[:60])
def test_models(model: str) -> None:
    Path("s.yaml").write_text(f"models:\n- {model}\n")
    assert MODELS[model] in refusal("run", "s.yaml")


@pytest.mark.parametrize("file", OBJECTS)
def test_objects(file: str) -> None:
    text, said = OBJECTS[file]
    Path(file).write_text(text, encoding="latin-1")
    Path("s.yaml").write_text(f"models:\n- {{name: f, file: finger.urdf}}\n- {{name: o, file: {file}}}\n")
    assert said in refusal("run", "s.yaml")


@pytest.mark.parametrize("before", FINGERS)
def test_fingers(before: str) -> None:
    after, said = FINGERS[before]
    assert before in FINGER
    Path("finger.urdf").write_text(FINGER.replace(before, after))
    Path("s.yaml").write_text("models:\n- {name: f, file: finger.urdf}\n")
    assert said in refusal("run", "s.yaml")


@pytest.mark.parametrize("arguments", OPTIONS, ids=lambda arguments: " ".join(arguments)[:60])
def test_options(arguments: tuple[str, ...]) -> None:
    assert OPTIONS[arguments] in refusal(*arguments)


@pytest.mark.parametrize("command", [["evaluate"], ["run", "free_bending"]], ids=" ".join)
def test_a_folder_to_which_another_process_writes(command: list[str]) -> None:
    claim = "from pathlib import Path; from soft_gripper.files.output import lock_folder\n"
    claim += "lock_folder(Path('out')); print('claimed', flush=True); input()"
    Path("out").mkdir()
    with subprocess.Popen([sys.executable, "-c", claim], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"claimed\n"
        assert "output: folder = 'out': another soft-gripper writes there" in refusal(*command, "--out", "out")
        other.communicate(b"\n")
    assert list(Path("out").iterdir()) == []


def test_no_port_for_meshcat(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> None:
        raise RuntimeError("Meshcat failed to open a websocket port.")

    monkeypatch.setattr(meshcats, "Meshcat", fail)
    assert "Meshcat: port = 'any': no free port" in refusal("run", "free_bending", "--html", "r.html", "--out", ".")
    with pytest.raises(InputError, match="no free port"):
        replay.hidden_meshcat()


def test_long_options_are_not_repeated_whole(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        soft_gripper("evaluate", "--trials", "y" * 50_000, "\x1b[2J")
    assert caught.value.code == 2
