"""Arms to try: the shipped one with its gripper, and small ones with textbook solutions."""

from collections.abc import Sequence
from pathlib import Path

from soft_gripper.scenario.schema import ArmConfig, ModelConfig, Scenario

HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)  # rad, of the UR5e: the tool points down
# Postures in which the gripper points down, up, level in two ways, and askew.
POSTURES = (
    HOME,
    (0.8, -1.5708, 1.5708, -1.5708, -1.5708, 1.5708),
    (-0.8, -1.5708, 1.5708, 0.0, -1.5708, 1.5708),
    (0.0, -1.2, 1.2, 1.5708, -1.5708, 0.8),
    (0.0, -1.5708, 1.5708, -1.5708, 0.0, 0.0),
    (-0.8, -1.5708, 1.5708, 0.0, -1.5708, 0.0),
    (1.2, -2.0, 1.9, -1.0, -0.8, -1.0),
)
GRIPPER = "package://soft_gripper/grippers/two_finger.urdf"

MASS, MOMENT = 2.0, 0.3  # kg, kg m^2 about z, of what the small arms carry: nothing else of them weighs anything
HAND = f"""<robot name="hand"><link name="hand"><inertial><mass value="{MASS}"/>
<inertia ixx="0.4" iyy="0.4" izz="{MOMENT}" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def ur5e(home: Sequence[float] = HOME) -> Scenario:
    """The shipped arm with the shipped gripper on its flange."""
    arm = ModelConfig("arm", "package://soft_gripper/arms/ur5e.urdf")
    gripper = ModelConfig("gripper", GRIPPER, parent="arm::tool0")
    return Scenario(models=[arm, gripper], arm=ArmConfig("arm", list(home)))


def small_arm(folder: Path, joints: str, home: Sequence[float], **config: float) -> Scenario:
    """A hand of MASS and MOMENT on an arm of the given joints, the last of which moves the link `flange`."""
    (folder / "arm.urdf").write_text(f'<robot name="arm"><link name="base"/>{joints}</robot>', encoding="utf-8")
    (folder / "hand.urdf").write_text(HAND, encoding="utf-8")
    arm = ModelConfig("arm", str(folder / "arm.urdf"))
    hand = ModelConfig("hand", str(folder / "hand.urdf"), parent="arm::flange")
    return Scenario(models=[arm, hand], arm=ArmConfig("arm", list(home), **config))


def joint(kind: str, parent: str, child: str, axis: str = "0 0 1", effort: float = 1e3, xyz: str = "0 0 0") -> str:
    """A joint called `{kind}_to_{child}`."""
    return (
        f'<joint name="{kind}_to_{child}" type="{kind}"><origin xyz="{xyz}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>'
        f'<limit lower="-9" upper="9" velocity="50" effort="{effort}"/></joint>'
    )


def motor(of_joint: str) -> str:
    """A transmission in the words of ROS."""
    return (
        f'<transmission name="{of_joint}_t"><type>transmission_interface/SimpleTransmission</type>'
        f'<joint name="{of_joint}"/><actuator name="{of_joint}_motor"/></transmission>'
    )
