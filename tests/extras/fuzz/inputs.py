"""Hostile input of every kind: files, and the command that is to read them."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import trimesh
import yaml
from damaged_files import damaged_bytes, damaged_recordings
from hostile import NUMBERS, WORDS, documents, elements, texts
from hypothesis import strategies as st
from live_inputs import commands
from log_forms import FORMS, table
from pydrake.common.yaml import yaml_dump

import soft_gripper as sg
from soft_gripper.models import DIRECTORY

FINGER = (DIRECTORY / "grippers/finger.urdf").read_text()
SECTIONS = (DIRECTORY / "grippers/conforming.urdf").read_text()
SCENARIO: dict[str, Any] = {
    "description": "one finger, and what it may meet",
    "models": [
        {"name": "finger", "file": "finger.urdf", "X_PC": {"rotation": {"_tag": "!Rpy", "deg": [180.0, 0.0, 0.0]}}},
        {"name": "thing", "file": "thing.sdf", "X_PC": {"translation": [1.0, 0.0, 0.5]}},
    ],
    "pressure": {"steps": {"all": [0.0, 3e4]}, "settle": 0.05, "hold_samples": 2, "time_constant": 0.05},
    "sensor": {"sections": 3, "period": 0.01, "errors": {"preset": "realistic", "delay": 1}, "seed": 3},
    "estimator": {"type": "gaussian", "alongside": ["arcs"], "contact_threshold": 0.01},
    "nominal": {"youngs_modulus": "+10 %", "response": [[1.0, 0.0], [2.0, 1.0]]},
    "plant_config": {"time_step": 0.01, "contact_model": "hydroelastic_with_fallback"},
    "simulator_config": {"accuracy": 1e-3, "max_step_size": 0.02},
    "gravity": [0.0, 0.0, -9.81],
}
PART = trimesh.creation.box((0.05, 0.04, 0.06)).export(file_type="stl_ascii")
THING = (DIRECTORY / "objects/box.sdf").read_text()
_INERTIAL = '<inertial><origin xyz="0 0 0"/><mass value="1"/>'
_INERTIAL += '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
_LIMIT = '<limit lower="-3" upper="3" velocity="3" effort="100"/>'
_TURNING = f'<axis xyz="0 1 0"/><dynamics damping="0.1" friction="0"/>{_LIMIT}'
ARM = f"""<robot name="arm"><link name="base">{_INERTIAL}</link>
<link name="upper">{_INERTIAL}<visual><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry>
<material name="grey"><color rgba="0.5 0.5 0.5 1"/></material></visual></link>
<link name="tool">{_INERTIAL}<collision><geometry><cylinder radius="0.02" length="0.02"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>{_TURNING}</joint>
<joint name="wrist" type="revolute"><parent link="upper"/><child link="tool"/><origin xyz="0 0 0.5" rpy="0 0.1 0"/>
{_TURNING}</joint></robot>"""
WITH_ARM: dict[str, Any] = {
    "models": [
        {"name": "arm", "file": "arm.urdf"},
        {"name": "finger", "file": "finger.urdf", "parent": "arm::tool", "X_PC": {"translation": [0.0, 0.0, 0.1]}},
    ],
    "arm": {"model": "arm", "home": [0.2, 0.3], "frequency": 10.0},
    "pressure": SCENARIO["pressure"],
}


@dataclass(frozen=True)
class Input:
    """Files by their names, and a command; a file is its content, the size of a sparse one, or where a link leads."""

    files: dict[str, bytes | int | str]
    arguments: list[str]


def scenario_input(text: str, name: str, scenario: dict[str, Any], command: str) -> Input:
    files = {"finger.urdf": FINGER, "thing.sdf": THING, "arm.urdf": ARM, "scenario.yaml": yaml_dump(scenario)}
    files |= {"part.sdf": THING, "part.stl": PART, name: text}
    encoded = {file: content.encode("utf-8", "surrogateescape") for file, content in files.items()}
    return Input(encoded, [command, "scenario.yaml"])


def _dump(document: Any) -> str:
    return yaml.dump(document) if not isinstance(document, dict) else _safe_dump(document)


def _safe_dump(document: dict[Any, Any]) -> str:
    try:
        text: str = yaml_dump(document)
    except Exception:  # what Drake does not write, a stranger does
        text = yaml.dump(document)
    return text


_COMMANDS = st.sampled_from(("show", "show", "run"))


def scenarios() -> st.SearchStrategy[Input]:
    """Scenarios whose data or text is changed, with an arm and without."""
    bases = (SCENARIO, WITH_ARM)
    data = [
        documents(base).map(lambda found: scenario_input(_dump(found), "scenario.yaml", {}, "run")) for base in bases
    ]
    text = [
        texts(yaml_dump(base)).map(lambda found: scenario_input(found, "scenario.yaml", {}, "show")) for base in bases
    ]
    return st.one_of(*data, *text)


def _models(name: str, base: str, scenario: dict[str, Any]) -> st.SearchStrategy[Input]:
    changed = st.one_of(elements(base), elements(base), texts(base))
    return st.builds(lambda text, command: scenario_input(text, name, scenario, command), changed, _COMMANDS)


def fingers() -> st.SearchStrategy[Input]:
    """URDF files with a finger, or with two of several sections."""
    return st.one_of(*(_models("finger.urdf", base, SCENARIO) for base in (FINGER, SECTIONS)))


def arms() -> st.SearchStrategy[Input]:
    """URDF files of an arm."""
    return _models("arm.urdf", ARM, WITH_ARM)


MJCF = """<mujoco model="arm"><compiler angle="radian" meshdir="." inertiagrouprange="0 2"/>
<default><geom density="900"/><default class="light"><geom mass="0.1" contype="1" conaffinity="0"/>
<position forcerange="-5 5"/></default></default><asset><mesh name="part" file="part.stl" scale="1 1 1"/></asset>
<worldbody><body name="base" pos="1 0 0.5" childclass="light"><geom type="box" size="0.1 0.1 0.1"/>
<body name="upper" pos="0 0 0.3"><joint name="shoulder" axis="0 1 0" range="-3 3"/>
<inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><geom type="mesh" mesh="part"/>
<body name="tool" pos="0 0 0.2" quat="1 0 0 0"><joint name="wrist" type="slide" axis="0 0 1" range="-1 1"/>
<joint name="turn" axis="1 0 0" range="-1 1"/><geom type="sphere" size="0.02" group="1"/></body></body></body>
</worldbody>
<actuator><motor name="a" joint="shoulder" gear="5" ctrlrange="-9 9" ctrllimited="true"/>
<position name="b" joint="wrist" class="light"/></actuator>
<equality><joint joint1="turn" joint2="wrist" polycoef="0.1 2 0 0 0"/></equality></mujoco>"""
NESTED = """<sdf version="1.7"><model name="thing"><link name="base"/><include><uri>part.sdf</uri><name>part</name>
<pose>0 0 0.1 0 0 1</pose></include><model name="other"><pose>0 1 0 0 0 0</pose><link name="a"/><frame name="f"
attached_to="a"><pose>1 0 0 0 0 0</pose></frame><link name="b"><pose relative_to="f"/></link>
<joint name="turn" type="revolute"><parent>a</parent><child>b</child><axis><xyz expressed_in="__model__">0 0 1</xyz>
</axis></joint></model>
<joint name="j" type="fixed"><parent>base</parent><child>other::a</child></joint>
<joint name="k" type="fixed"><parent>base</parent><child>part::box</child></joint></model></sdf>"""


def mjcf() -> st.SearchStrategy[Input]:
    """MJCF files of an arm and of a fixture, with classes, actuators and equalities."""
    arm = {**WITH_ARM["arm"], "limits": {name: {"velocity": 1.0, "effort": 9.0} for name in ("shoulder", "wrist")}}
    finger = {**WITH_ARM["models"][1]}
    moved = {**WITH_ARM, "models": [{"name": "arm", "file": "arm.xml"}, finger], "arm": arm}
    stays = {**SCENARIO, "models": [SCENARIO["models"][0], {"name": "thing", "file": "arm.xml"}]}
    return st.one_of(_models("arm.xml", MJCF, moved), _models("arm.xml", MJCF, stays))


def nested() -> st.SearchStrategy[Input]:
    """SDFormat files that include another and nest a model."""
    return _models("thing.sdf", NESTED, SCENARIO)


def objects() -> st.SearchStrategy[Input]:
    """SDFormat and URDF files of an object."""
    as_urdf = {**SCENARIO, "models": [SCENARIO["models"][0], {**SCENARIO["models"][1], "file": "arm.urdf"}]}
    return st.one_of(_models("thing.sdf", THING, SCENARIO), _models("arm.urdf", ARM, as_urdf))


def meshes() -> st.SearchStrategy[Input]:
    """Meshes of every format, with changes in their text or bytes."""
    box = trimesh.creation.box((0.05, 0.04, 0.06))
    exported = {kind: box.export(file_type=kind) for kind in ("obj", "stl", "stl_ascii", "ply", "off", "glb")}
    exported["gltf"] = trimesh.exchange.gltf.export_gltf(trimesh.Scene(box), embed_buffers=True)["model.gltf"]
    return st.one_of(*(_mesh(kind.partition("_")[0], content) for kind, content in exported.items()))


def _mesh(suffix: str, content: str | bytes) -> st.SearchStrategy[Input]:
    text = content if isinstance(content, str) else content.decode("utf-8", "surrogateescape")
    thing = {**SCENARIO["models"][1], "file": f"thing.{suffix}"}
    scenario = {**SCENARIO, "models": [SCENARIO["models"][0], thing]}
    return texts(text).map(lambda changed: scenario_input(changed, f"thing.{suffix}", scenario, "show"))


def _choice(*options: str) -> st.SearchStrategy[str]:
    return st.sampled_from((*options, *NUMBERS, *WORDS)).filter(lambda text: "\0" not in text)


def _changes() -> st.SearchStrategy[str]:
    """What --set may be given."""
    keys = _choice("sensor.sections", "models.0.name", "models.0.X_PC", "estimator.type", "sensor.seed", "gravity.0")
    return st.builds("{}={}".format, keys, _choice("[1, 2]", "{a: 1}", "!Rpy {deg: [1]}", "+10 %"))


def command_lines() -> st.SearchStrategy[Input]:
    """Commands with options of any value. What would be long by right has one that cannot be."""
    run = st.builds(
        lambda name, option, value, new: ["run", name, option, value, "--set", new, "--set", "models=[]"],
        _choice("free_bending", "scenario.yaml"),
        st.sampled_from(("--out", "--html", "--video", "--sections", "--frob", "--set")),
        _choice("file", "folder/x.html"),
        _changes(),
    )
    show = st.builds(
        lambda first, second: ["show", "scenario.yaml", "--set", first, "--set", second], _changes(), _changes()
    )
    expand = st.builds(
        lambda file, option, value: ["expand", file, option, value],
        _choice("finger.urdf", "thing.sdf"),
        st.sampled_from(("--out", "--segments", "-o")),
        _choice("folder", "finger.urdf"),
    )
    numbers = st.builds(
        lambda command, option, value: [*command, option, value, "--jobs", "0", "--out", "folder"],
        st.sampled_from((["evaluate"], ["study", "grasp-trials"], ["study", "health"])),
        st.sampled_from(("--trials", "--seed", "--runs", "--scenario", "--train")),
        _choice("1", "free_bending"),
    )
    reading = st.builds(
        lambda words, value: [word.replace("*", value) for word in words],
        st.sampled_from(
            (
                ["calibrate", "*", "--out", "calibration.yaml"],
                ["calibrate", "finger.urdf", "--out", "*"],
                ["replay", "*"],
                ["replay", "thing.sdf", "--as", "*"],
                ["identify", "thing.sdf", "--finger", "*", "--free", "length", "--out", "found.urdf"],
                ["weigh", "thing.sdf", "--finger", "*"],
                ["tune", "free_bending", "--set", "sensor.seed=*"],
            )
        ),
        _choice("finger.urdf", "folder", "."),
    )
    lines = st.one_of(run, show, expand, numbers, reading)
    return lines.map(lambda arguments: Input(scenario_input("", "empty", SCENARIO, "show").files, arguments))


SIGNALS = "strain", "sampled_pressure", "X_WB"


def recordings() -> st.SearchStrategy[Input]:
    """Recordings of a run, of which a signal or bytes are damaged."""
    steps = "pressure.steps.all=[0, 180e3]", "pressure.settle=0.6", "pressure.hold_samples=10", "sensor.sections=2"
    data = sg.simulate(sg.load_scenario("free_bending", steps)).data
    data = data[[name for name in data if str(name).partition(".")[2] in SIGNALS]]
    damaged = damaged_recordings(data, [f"left_finger.{signal}" for signal in SIGNALS], seed=1)
    files = _damaged(damaged, bytes(data.to_netcdf(engine="scipy")))
    return files.map(lambda file: Input({"a.nc": file}, ["calibrate", "a.nc", "--out", "calibration.yaml"]))


_FINGER_OF_LOG = {
    "models": [{"name": "finger", "file": "package://soft_gripper/grippers/finger.urdf"}],
    "gravity": [0.0, 0.0, -9.81],
    "sensor": {"sections": 2, "response": [[1.0, 2048.0], [1.5, 4048.0]]},
}
_OF_LOG = """
time: t
readings: [a, b, c, d]
pressures: {columns: [p], unit: kPa}
frame: {origin: [0, 0, 0]}
length: 0.12
"""


def logs() -> st.SearchStrategy[Input]:
    """A log in one of the forms that are read, whole or with changes in its text, and its description."""
    time = np.arange(200) / 100
    counts = np.round(2048 + 20 * np.sin(time[:, None] * [1, 2, 3, 4]))
    columns = dict(zip("tabcdp", [time, *counts.T, 30 + 10 * np.sin(time)], strict=True))
    content = table(columns)
    forms = [(each.content, each.more) for each in (form(content) for form in FORMS.values())]
    whole = st.sampled_from(forms)
    broken = whole.flatmap(
        lambda form: texts(form[0].decode("utf-8", "surrogateescape")).map(
            lambda text: (text.encode("utf-8", "surrogateescape"), form[1])
        )
    )
    noise = st.builds(lambda form, seed: (damaged_bytes(form[0], seed), form[1]), whole, st.integers(0, 2**32 - 1))
    more = st.sampled_from(
        (
            "",
            "",
            "text: {decimal: ','}",
            "text: {separator: ' '}",
            "text: {encoding: utf-16}",
            "hold: 0.05\npause: 5",
            "time_unit: min",
        )
    )
    return st.builds(log_input, st.one_of(whole, broken, broken, noise), more)


def log_input(log: tuple[bytes, str], more: str) -> Input:
    described = "\n".join((_OF_LOG, log[1], more)).encode()
    files = {"log.csv": log[0], "d.yaml": described, "finger.yaml": yaml_dump(_FINGER_OF_LOG).encode()}
    return Input(files, ["calibrate", "log.csv", "--scenario", "finger.yaml", "--as", "d.yaml", "--out", "found.yaml"])


def _damaged(known: Iterator[tuple[str, bytes]], whole: bytes) -> st.SearchStrategy[bytes]:
    """One of the kinds of damage that are known, or any bytes of a whole file."""
    anywhere = st.integers(0, 2**32 - 1).map(lambda seed: damaged_bytes(whole, seed))
    return st.one_of(st.sampled_from([content for _, content in known]), anywhere)


def numbers() -> st.SearchStrategy[Input]:
    """A number of a scenario, any of them, of any size."""
    names = "box_grasp", "pick_and_place_box", "tip_distance_steps", "three_finger_grasp"
    fields = [(name, field) for name in names for field in _numeric(asdict(sg.load_scenario(name)))]
    return st.builds(
        lambda place, value: Input({}, ["show", place[0], "--set", f"{place[1]}={value}"]),
        st.sampled_from(fields),
        st.sampled_from((*NUMBERS, "1e-308", "1e15", "1e-15", "-1e15")),
    )


def _numeric(value: Any, field: str = "") -> Iterator[str]:
    """The dotted names of the numbers in plain data."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _numeric(item, f"{field}.{key}" if field else str(key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield field


DIRECTIVES: dict[str, Any] = {
    "directives": [
        {"add_model_instance": {"name": "left"}},
        {"add_frame": {"name": "shelf", "X_PF": {"base_frame": "world", "translation": [0.5, 0.0, 0.3]}}},
        {
            "add_model": {
                "name": "acrobot",
                "file": "package://drake/examples/acrobot/Acrobot_no_collision.urdf",
                "default_joint_positions": {"elbow": [0.4]},
            }
        },
        {"add_weld": {"parent": "shelf", "child": "acrobot::base_link", "X_PC": {"translation": [0.0, 0.0, 0.1]}}},
        {"add_collision_filter_group": {"name": "g", "members": ["acrobot::upper_link"], "member_groups": []}},
    ]
}
ADDS = {"directives": [{"add_directives": {"file": "a.dmd.yaml"}}], "models": SCENARIO["models"][:1]}


def directives_input(text: str) -> Input:
    return scenario_input(text, "a.dmd.yaml", ADDS, "show")


def directives() -> st.SearchStrategy[Input]:
    """Files of Drake's directives whose data or text is changed."""
    whole = yaml_dump(DIRECTIVES)
    return st.one_of(documents(DIRECTIVES).map(_dump), texts(whole)).map(directives_input)


KINDS: dict[str, Callable[[], st.SearchStrategy[Input]]] = {
    "scenarios": scenarios,
    "fingers": fingers,
    "arms": arms,
    "objects": objects,
    "mjcf": mjcf,
    "nested": nested,
    "meshes": meshes,
    "directives": directives,
    "command lines": command_lines,
    "recordings": recordings,
    "logs": logs,
    "numbers": numbers,
    "live": lambda: commands().map(lambda found: Input(*found)),
}
