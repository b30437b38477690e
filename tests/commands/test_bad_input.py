"""Bad input: one line that names file, field and value, exit code 2, and no file left behind."""

import re
from pathlib import Path

import pytest
from command_line import short, soft_gripper

from soft_gripper.models import DIRECTORY

FINGER = (DIRECTORY / "grippers" / "finger.urdf").read_text()
WRONG_FIELDS = [
    ("sensor.sectoins=3", ["sensor.sectoins", "3", "sections"]),
    ("sensr.sections=3", ["sensr", "sensor"]),
    ("sensor.sections=2.5", ["sections", "2.5"]),
    ("sensor.period=0", ["sensor.period", "0"]),
    ("models.0.segments=-1", ["models[0].segments", "-1"]),
    ("models.0.file=nosuch.urdf", ["models[0]", "file", "nosuch.urdf"]),
    ("models.0.parent=hand::palm", ["models[0]", "parent", "hand::palm"]),
    ("models=[]", ["models", "[]"]),
    ("gravity=[0, 1]", ["gravity", "[0, 1]"]),
    ("pressure.steps.all=[0, 9e9]", ["pressure.steps.all[1]", "9000000000", "210000"]),
    ("pressure.steps.all=[.nan]", ["pressure.steps.all[0]", "nan"]),
    ("pressure.settle=-1", ["pressure.settle", "-1"]),
    ("pressure.hold_samples=0", ["pressure.hold_samples", "0"]),
    ("pressure.steps.left_fingr=[0]", ["pressure.steps", "left_fingr"]),
    ("plant_config.time_step=0.1", ["time_step", "0.1", "stable_time_step", "0.013", "left_finger"]),
    ("plant_config.contact_model=sticky", ["plant_config.contact_model", "sticky"]),
    ("sensor.type=strian", ["sensor.type", "strian", "strain"]),
    ("sensor.type=math:pi", ["sensor.type", "math:pi", "callable"]),
    ("estimator.type=nowhere:make", ["estimator.type", "nowhere:make", "imported"]),
    ("nominal.lenght=0.1", ["nominal.lenght", "0.1", "length"]),
    ("nominal.youngs_modulus=stiff", ["free_bending: nominal: youngs_modulus", "stiff", "+10 %"]),
    ("nominal.youngs_modulus=-100 %", ["nominal: finger", "left_finger", "base.youngs_modulus", "0.0"]),
    ("nominal.response=[[1, 0]]", ["nominal.response", "[[1.0, 0.0]]"]),
    ("external=[pressur]", ["external[0]", "pressur", "pressure"]),
    ("simulator_config.integration_scheme=exact", ["integration_scheme", "exact", "cenic"]),
]
WRONG_TASKS = [
    ("arm.model=leg", ["arm.model", "leg", "gripper", "workbench", "box"]),
    ("arm.home=[0, 0, 0]", ["arm", "home", "shoulder_pan_joint", "wrist_3_joint"]),
    ("arm.home=[0, 0, 7, 0, 0, 0]", ["arm.home", "elbow_joint", "7", "3.14159"]),
    ("models.1.parent=arm::tol0", ["models[1]", "parent", "arm::tol0", "tool0"]),
    ("models.1.parent=world", ["arm", "does not carry the gripper"]),
    ("models.1.file=package://soft_gripper/objects/box.sdf", ["fingers", "two fingers"]),
    ("models.3.X_PC.translation=[2, 0, 0.04]", ["task.phases[0]", "object", "reach"]),
    ("task.object=bx", ["task.object", "bx", "box"]),
    ("task.X_WGoal.translation=[0.45, 3, 0.04]", ["task.phases[4]", "goal", "reach"]),
    ("task.phases.1.to=objct", ["task.phases[1].to", "objct", "object"]),
    ("task.phases.1.spd=2", ["task.phases[1].spd", "2", "speed"]),
    ("task.phases.1.height=-0.1", ["task.phases[1]", "descend", "workbench"]),
    ("control.torque_limit=-1", ["control.torque_limit", "-1"]),
    ("estimator.contact_threshold=-1", ["estimator.contact_threshold", "-1"]),
]
LIMP = """<robot name="limp"><link name="base_link"/><link name="tool0"/><joint name="shoulder" type="revolute">
<parent link="base_link"/><child link="tool0"/></joint></robot>"""
WRONG_SYNTAX = ["sensor.sections", "=3", "sensor.sections=[1,", "models.7.name=x", "models.first.name=x"]
WRONG_FINGERS = [
    ('thickness="0.02"', 'thickness="-0.02"', ["base.thickness", "-0.02"]),
    ('youngs_modulus="2.67e5"', 'youngs_modulus="-8e5"', ["base.youngs_modulus", "-800000"]),
    ('youngs_modulus="2.67e5"', 'youngs_modulus="soft"', ["base.youngs_modulus", "soft"]),
    ('length="0.12"', 'length="nan"', ["length", "nan"]),
    ('segments="12"', 'segments="0"', ["segments", "0"]),
    ('segments="12"', 'segments="2.5"', ["segments", "2.5"]),
    (' density="1070"', "", ["base.density", "missing"]),
    ("density", "densty", ["base", "densty", "density"]),
    ('<sensors spacing="0.017"/>', "", ["sensors", "missing"]),
    ("<sensors", "<sensor", ["sensor", "sensors"]),
    ('<parent link="mount"/>', '<parent link="hand"/>', ["parent.link", "hand", "mount"]),
]
UNREADABLE = {
    "absent": None,
    "binary": b"\xff\xfe\x00",
    "broken": b"a: [1",
    "list": b"- 1",
    "empty": b"",
}


@pytest.fixture(autouse=True)
def _work_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("a file, below which nothing can be written, not even by root")


def complaint(*arguments: object) -> str:
    """The one line that a command ends with; all else that must not happen is checked."""
    before = files()
    outcome = soft_gripper(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.startswith("soft-gripper: ")
    assert outcome.err.count("\n") == 1
    assert files() == before
    return outcome.err


def files() -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def require(line: str, *parts: str) -> None:
    """Each part stands in the line as a word of its own."""
    for part in parts:
        assert re.search(rf"(?<!\w){re.escape(part)}(?!\w)", line), f"{part!r} is not in {line!r}"


@pytest.mark.parametrize(("override", "parts"), WRONG_FIELDS, ids=[override for override, _ in WRONG_FIELDS])
def test_wrong_field_of_a_scenario(override: str, parts: list[str]) -> None:
    line = complaint("run", "free_bending", *short(override))
    assert "free_bending" in line
    require(line, *parts)


@pytest.mark.parametrize(("override", "parts"), WRONG_TASKS, ids=[override for override, _ in WRONG_TASKS])
def test_wrong_arm_or_task(override: str, parts: list[str]) -> None:
    """Refused before anything moves."""
    require(complaint("run", "pick_and_place_box", "--set", override), *parts)


def test_arm_without_limits() -> None:
    Path("limp.urdf").write_text(LIMP)
    line = complaint("run", "pick_and_place_box", "--set", f"models.0.file={Path('limp.urdf').resolve()}")
    require(line, "limp.urdf", "shoulder", "limit", "missing", "effort", "velocity")


@pytest.mark.parametrize("sections", [0, 99, "four"])
def test_wrong_number_of_sections(sections: object) -> None:
    line = complaint("run", "free_bending", "--sections", sections)
    require(line, "sections", str(sections))


@pytest.mark.parametrize("override", WRONG_SYNTAX)
def test_wrong_syntax_of_an_override(override: str) -> None:
    line = complaint("run", "free_bending", "--set", override)
    assert "--set" in line
    assert override.split("=")[0] in line


def test_unknown_scenario_names_the_known_ones() -> None:
    line = complaint("run", "free_bendig")
    require(line, "free_bendig", "free_bending")


@pytest.mark.parametrize(("text", "wrong", "parts"), WRONG_FINGERS, ids=[wrong for _, wrong, _ in WRONG_FINGERS])
def test_wrong_finger(text: str, wrong: str, parts: list[str]) -> None:
    assert text in FINGER
    Path("wrong.urdf").write_text(FINGER.replace(text, wrong))
    Path("wrong.yaml").write_text("models: [{name: index, file: wrong.urdf}]")
    require(complaint("expand", "wrong.urdf", "-o", "plain.urdf"), "wrong.urdf", "finger", *parts)
    require(complaint("run", "wrong.yaml"), "index", *parts)


@pytest.mark.parametrize("segments", [0, -3, 2.5, "many"])
def test_wrong_number_of_segments(segments: object) -> None:
    Path("finger.urdf").write_text(FINGER)
    require(complaint("expand", "finger.urdf", "--segments", segments), "segments", str(segments))


def test_nothing_to_expand() -> None:
    Path("plain.urdf").write_text("<robot name='plain'><link name='base'/></robot>")
    require(complaint("expand", "plain.urdf"), "plain.urdf", "finger")


@pytest.mark.parametrize("kind", UNREADABLE)
@pytest.mark.parametrize(("command", "ending"), [("run", "yaml"), ("show", "yaml"), ("expand", "urdf")])
def test_unreadable_file(command: str, ending: str, kind: str) -> None:
    content = UNREADABLE[kind]
    if content is not None:
        Path(f"{kind}.{ending}").write_bytes(content)
    require(complaint(command, f"{kind}.{ending}"), f"{kind}.{ending}")


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "free_bending", "--out", "file/below"],
        ["run", "free_bending", "--html", "file/replay.html"],
        ["show", "free_bending", "--graphviz", "file/blocks.dot"],
        ["show", "free_bending", "--graphviz", "file/blocks.svg"],
        ["show", "free_bending", "--graphviz", "blocks.bmp"],
        ["expand", "package://soft_gripper/grippers/finger.urdf", "-o", "file/plain.urdf"],
        ["evaluate", "--out", "file/below"],
    ],
    ids=lambda arguments: arguments[-1],
)
def test_unwritable_output(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("soft_gripper.commands.run.Meshcat", None, raising=False)  # not to be started for nothing
    require(complaint(*arguments), arguments[-1].split("/")[0])


@pytest.mark.parametrize("jobs", ["0", "-1", "two"])
def test_wrong_number_of_jobs(jobs: str) -> None:
    require(complaint("evaluate", "--jobs", jobs), "--jobs", jobs)
