"""Model directives beside fingers: the example of Drake's hardware_sim, its frames as parents, and what is refused."""

import os
import pickle
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import PackageMap, Parser
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.diagrams import loaded_model
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.models import package_map
from soft_gripper.scenario import directives as module
from soft_gripper.scenario import model_files
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario, parse_scenario
from soft_gripper.scenario.schema import Scenario

POSTURE = [-0.2, 0.79, 0.32, -1.76, -0.36, 0.64, -0.73]  # rad
OPEN = [-0.02, 0.02]  # m
TABLE = "package://drake_models/manipulation_station/amazon_table_simplified.sdf"
IIWA = "package://drake_models/iiwa_description/urdf/iiwa14_primitive_collision.urdf"
WSG = "package://drake_models/wsg_50_description/sdf/schunk_wsg_50_with_tip.sdf"
PEPPER = "package://drake_models/veggies/yellow_bell_pepper_no_stem_low.sdf"
# The kinds of directives of hardware_sim's Demo, with its names and numbers: an arm with a gripper, a table, a pepper.
DEMO = f"""\
directives:
- add_model: {{name: amazon_table, file: {TABLE}}}
- add_weld: {{parent: world, child: amazon_table::amazon_table}}
- add_model:
    name: iiwa
    file: {IIWA}
    default_joint_positions: {{{", ".join(f"iiwa_joint_{i + 1}: [{angle}]" for i, angle in enumerate(POSTURE))}}}
- add_frame:
    name: iiwa_on_world
    X_PF: {{base_frame: world, translation: [0, -0.7, 0.1], rotation: !Rpy {{deg: [0, 0, 90]}}}}
- add_weld: {{parent: iiwa_on_world, child: iiwa::base}}
- add_model:
    name: wsg
    file: {WSG}
    default_joint_positions: {{left_finger_sliding_joint: [{OPEN[0]}], right_finger_sliding_joint: [{OPEN[1]}]}}
- add_frame:
    name: wsg_on_iiwa
    X_PF: {{base_frame: iiwa_link_7, translation: [0, 0, 0.114], rotation: !Rpy {{deg: [90, 0, 90]}}}}
- add_weld: {{parent: wsg_on_iiwa, child: wsg::body}}
- add_model:
    name: bell_pepper
    file: {PEPPER}
    default_free_body_pose: {{flush_bottom_center__z_up: {{base_frame: amazon_table::amazon_table,
      translation: [0, 0.10, 0.20]}}}}
"""
MODELS = """\
models:
- {name: gripper, file: package://soft_gripper/grippers/two_finger.urdf,
   X_PC: {translation: [1.5, 0, 0.6], rotation: !Rpy {deg: [180, 0, 0]}}}
pressure: {steps: {all: [4.0e4]}, settle: 0.1, hold_samples: 10}
"""
_SOLID = '<mass value="0.5"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2" ixy="0" ixz="0" iyz="0"/>'
_MASS = "<inertial><mass>0.2</mass><inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia></inertial>"


def _box(size: str, pose: str) -> str:
    return f'<collision name="c"><pose>{pose}</pose><geometry><box><size>{size}</size></box></geometry></collision>'


def _stand_ins() -> dict[str, str]:
    """Models of the links, joints and frames that the directives name, by URI."""
    links = ["base", *(f"iiwa_link_{i}" for i in range(1, 8))]
    arm = "".join(f'<link name="{link}"><inertial>{_SOLID}</inertial></link>' for link in links)
    for i, (parent, child) in enumerate(pairwise(links), start=1):
        arm += f"""<joint name="iiwa_joint_{i}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
            <origin xyz="0 0 0.15"/><axis xyz="0 {i % 2} {1 - i % 2}"/>
            <limit lower="-2.9" upper="2.9" effort="300" velocity="2"/></joint>"""
    jaws = "".join(
        f"""<link name="{side}_finger">{_MASS}</link><joint name="{side}_finger_sliding_joint" type="prismatic">
        <parent>body</parent><child>{side}_finger</child><axis><xyz>1 0 0</xyz></axis></joint>"""
        for side in ("left", "right")
    )
    sdf = '<sdf version="1.7"><model name="m">{}</model></sdf>'
    return {
        TABLE: sdf.format(f'<link name="amazon_table">{_MASS}{_box("0.7 1 0.1", "0 0 -0.05 0 0 0")}</link>'),
        IIWA: f'<robot name="iiwa14">{arm}</robot>',
        WSG: sdf.format(f'<link name="body">{_MASS}</link>{jaws}'),
        PEPPER: sdf.format(
            f'<link name="flush_bottom_center__z_up">{_MASS}{_box("0.06 0.06 0.06", "0 0 0.03 0 0 0")}</link>'
        ),
    }


def _is_downloaded() -> bool:
    """Whether Drake's own package of models is in its cache; Drake downloads it otherwise."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "drake/package_map"
    return cache.is_dir() and any(cache.glob("*/package.xml"))


@pytest.fixture(params=["stand-ins", "drake_models"])
def packages(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where drake_models is: a folder of stand-ins, or the package itself."""
    if request.param == "stand-ins":
        folder = tmp_path / "drake_models"
        for uri, text in _stand_ins().items():
            file = folder / uri.removeprefix("package://drake_models/")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)

        def with_stand_ins() -> PackageMap:
            found = package_map()
            found.Remove("drake_models")
            found.Add("drake_models", str(folder))
            return found

        def parser_without(plant: MultibodyPlant) -> Parser:
            parser = Parser(plant)
            parser.package_map().Remove("drake_models")  # whose place would be taken
            return parser

        for part in (module, loaded_model):
            monkeypatch.setattr(part, "Parser", parser_without)
        for part in (module, loaded_model, model_files):
            monkeypatch.setattr(part, "package_map", with_stand_ins)
    elif not _is_downloaded():
        pytest.skip("drake_models is not in Drake's cache, and tests download nothing")


def scenario_of(folder: Path, text: str) -> Scenario:
    (folder / "scenario.yaml").write_text(text)
    return load_scenario(folder / "scenario.yaml")


def _pose(station: Station, model: str, body: str) -> RigidTransform:
    plant = station.plant
    context = plant.GetMyContextFromRoot(station.diagram.CreateDefaultContext())
    return plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(body, plant.GetModelInstanceByName(model)))


def test_the_demo_beside_a_gripper(packages: None, tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, DEMO + MODELS)
    beside, alone = simulate(scenario).data, simulate(scenario_of(tmp_path, MODELS)).data
    state = beside["plant.state"]
    arm = state.sel(state=[name for name in state.state.values if "iiwa_joint" in name and name.endswith("_q")])
    jaws = state.sel(state=[name for name in state.state.values if "sliding" in name and name.endswith(("_x", "_q"))])
    np.testing.assert_allclose(arm[0], POSTURE)
    np.testing.assert_allclose(jaws[0], OPEN)
    assert np.abs(arm[-1] - arm[0]).max() > 1e-3  # nothing drives it
    fingers = [name for name in alone if name.endswith(".theta")]
    assert len(fingers) == 2
    for name in fingers:
        assert np.abs(alone[name][-1]).max() > 0.01
        np.testing.assert_allclose(beside[name], alone[name], atol=1e-6)  # rad; nothing reaches the gripper


def test_poses(packages: None, tmp_path: Path) -> None:
    station = make_station(scenario_of(tmp_path, DEMO + MODELS))
    expected = RigidTransform(RollPitchYaw(0, 0, np.pi / 2), [0, -0.7, 0.1])
    assert _pose(station, "iiwa", "base").IsNearlyEqualTo(expected, 1e-12)
    X_7B = RigidTransform(RollPitchYaw(np.pi / 2, 0, np.pi / 2), [0, 0, 0.114])
    flange = _pose(station, "iiwa", "iiwa_link_7")
    assert _pose(station, "wsg", "body").IsNearlyEqualTo(flange @ X_7B, 1e-12)


@pytest.mark.parametrize("packages", ["stand-ins"], indirect=True)
@pytest.mark.parametrize("parent", ["iiwa_on_world", "iiwa::wsg_on_iiwa", "iiwa::iiwa_link_7"])
def test_a_gripper_on_what_directives_add(packages: None, tmp_path: Path, parent: str) -> None:
    line = f"- {{name: g, file: package://soft_gripper/grippers/finger.urdf, parent: '{parent}'}}\n"
    station = make_station(scenario_of(tmp_path, DEMO + "models:\n" + line))
    plant = station.plant
    (finger,) = station.fingers
    context = plant.GetMyContextFromRoot(station.diagram.CreateDefaultContext())
    expected = plant.GetFrameByName(parent.rpartition("::")[2]).CalcPoseInWorld(context)
    first = plant.get_body(plant.GetBodyIndices(finger.model)[0])
    assert plant.EvalBodyPoseInWorld(context, first).IsNearlyEqualTo(expected, 1e-12)


FINGER = (
    "models:\n- {name: finger, file: package://soft_gripper/grippers/finger.urdf, X_PC: {translation: [0, 0, 1]}}\n"
)
PENDULUM = "package://drake/examples/pendulum/Pendulum.urdf"


def test_a_file_of_directives_in_a_namespace(tmp_path: Path) -> None:
    (tmp_path / "scene.dmd.yaml").write_text(f"directives:\n- add_model: {{name: arm, file: {PENDULUM}}}\n")
    text = "directives:\n- add_model_instance: {name: left}\n"
    text += "- add_directives: {file: scene.dmd.yaml, model_namespace: left}\n"
    text += "models:\n- {name: finger, file: package://soft_gripper/grippers/finger.urdf, parent: 'left::arm::arm'}\n"
    scenario = scenario_of(tmp_path, text)
    station = make_station(scenario)
    assert station.plant.HasModelInstanceNamed("left::arm")
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert parse_scenario(tmp_path / "copy.yaml", dump_scenario(scenario, tmp_path)) == scenario


@pytest.mark.parametrize(
    ("directive", "field"),
    [
        ("add_model: {name: a, file: none.urdf}", "file"),
        ("add_model: {name: a, file: package://nowhere/a.urdf}", "file"),
        ("add_model: {name: a, file: package://soft_gripper/grippers/finger.urdf}", "file"),
        ("add_weld: {parent: world, child: a::b}", "directives"),
        (f"add_model: {{name: a, file: {PENDULUM}, default_joint_positions: {{elbow: [1]}}}}", "directives"),
        (f"add_model: {{name: finger, file: {PENDULUM}}}", "name"),
    ],
)
def test_directives_that_are_refused(tmp_path: Path, directive: str, field: str) -> None:
    with refused(field):
        make_station(scenario_of(tmp_path, f"directives:\n- {directive}\n{FINGER}"))


def _files(*texts: str) -> dict[str, str]:
    """Files of directives by name: the first is the one that the scenario adds."""
    return {f"{name}.dmd.yaml": text for name, text in zip("abcdefg", texts, strict=False)}


def _adds(*names: str) -> str:
    return "directives:\n" + "".join(f"- add_directives: {{file: 'file://FOLDER/{name}.dmd.yaml'}}\n" for name in names)


_PAIRS = [_adds(name, name) for name in "bcdefg"]
_FRAMES = ", ".join(f"{{add_frame: {{name: f{i}, X_PF: {{base_frame: world}}}}}}" for i in range(20))
_LAUGHS = "".join(f"_{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcde", "bcdef", strict=True))
ENDLESS = {
    "itself": (_files(_adds("a")), "directives[0]: file = 'file://FOLDER/a.dmd.yaml': adds itself"),
    "a pipe": (
        _files(_adds("pipe")),
        "pipe.dmd.yaml: file = 'pipe.dmd.yaml': cannot be read: it is not a regular file",
    ),
    "a tree": (_files(*_PAIRS, f"directives: [{_FRAMES}]"), "count = 1407: give no more than 1000 directives"),
    "no file": (_files(_adds("none")), "none.dmd.yaml: file = 'none.dmd.yaml': cannot be read: No such file"),
    "a relative path": (_files("directives: [{add_directives: {file: b}}]"), "file = 'b': give file:///... or package"),
    "an alias": (_files("directives: &a [*a]"), "a.dmd.yaml: alias = 'a': stands inside what it stands for"),
    "laughs": (_files(f"_a: &a [1]\n{_LAUGHS}directives: *f"), "a.dmd.yaml: size = "),
    "nothing": (_files(""), "a.dmd.yaml: file = 'a.dmd.yaml': holds no directives"),
    "a model": (
        _files("directives: [{add_model: {name: x, file: 'file://FOLDER/a.dmd.yaml'}}]"),
        "holds directives: add them by add_directives",
    ),
}


@pytest.mark.parametrize(("files", "line"), ENDLESS.values(), ids=ENDLESS)
def test_files_of_directives_that_are_refused(tmp_path: Path, files: dict[str, str], line: str) -> None:
    os.mkfifo(tmp_path / "pipe.dmd.yaml")
    for name, text in files.items():
        (tmp_path / name).write_text(text.replace("FOLDER", str(tmp_path)))
    scenario = scenario_of(tmp_path, f"directives: [{{add_directives: {{file: a.dmd.yaml}}}}]\n{FINGER}")
    with pytest.raises(InputError) as caught:
        make_station(scenario)
    assert line.replace("FOLDER", str(tmp_path)) in str(caught.value)


def test_files_of_directives_as_drake_reads_them(tmp_path: Path) -> None:
    """Poses with every rotation, nested files in a namespace, templates, groups; the last line may end anywhere."""
    (tmp_path / "inner.dmd.yaml").write_text(
        f"directives:\n- add_model: {{name: arm, file: {PENDULUM}, default_joint_positions: {{theta: [0.4]}}}}\n"
        "- add_collision_filter_group: {name: g, members: ['arm::arm'], ignored_collision_filter_groups: [g]}"
    )
    (tmp_path / "outer.dmd.yaml").write_text(
        f"""\
directives:
- add_model_instance: {{name: left}}
- add_directives: {{file: 'file://{tmp_path}/inner.dmd.yaml', model_namespace: left}}
- add_frame: &frame
    name: one
    X_PF: {{base_frame: 'left::arm::arm', rotation: !AngleAxis {{angle_deg: 90, axis: [0, 0, 2]}}}}
- add_frame: {{<<: *frame, name: other, X_PF: {{base_frame: one, rotation: !Identity {{}}, translation: [1e-1, 0, 0]}}}}
- add_frame: {{name: third, X_PF: {{base_frame: world, translation: [0, 0, 1], rotation: !Rpy {{deg: [0, 0, 90]}}}}}}"""
    )
    text = f"directives: [{{add_directives: {{file: outer.dmd.yaml}}}}]\n{FINGER.replace('[0, 0, 1]', '[3, 0, 1]')}"
    plant = make_station(scenario_of(tmp_path, text)).plant
    arm = plant.GetModelInstanceByName("left::arm")
    one, other = (plant.GetFrameByName(name, arm) for name in ("one", "other"))
    p_OneOther = other.GetFixedPoseInBodyFrame().translation() - one.GetFixedPoseInBodyFrame().translation()
    np.testing.assert_allclose(p_OneOther, [0, 0.1, 0], atol=1e-12)
    assert plant.HasFrameNamed("third")
