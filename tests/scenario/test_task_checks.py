"""What breaks a rule of the arm or of the task is refused with the field, the value and what would do."""

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario_file import load_scenario

NAN, INFINITE = ".nan", ".inf"
TASK, MOTION = "pick_and_place_box", "arm_motion"

UNKNOWN_KEYS_AND_TYPES = [
    ("arm.mdel=x", "arm.mdel = 'x': no such key; did you mean 'model'"),
    ("arm.home=0.1", "arm.home = 0.1"),
    ("arm.home=[up]", r"arm.home\[0\] = 'up'"),
    ("task.phases={}", "task.phases = {}"),
    ("task.phases=[go]", r"task.phases\[0\] = 'go'"),
    ("task.phases.0.openin=0.1", r"task.phases\[0\].openin = 0.1: no such key; did you mean 'opening'"),
    ("task.phases.1.straight=1", r"task.phases\[1\].straight = 1"),
    ("task.phases.1.to=[object]", r"task.phases\[1\].to = \['object'\]"),
    ("task.X_OG.translation=[0, 1]", r"task.X_OG.translation = \[0, 1\]"),
    ("task.X_WGoal.rotation=!Rpy {deg: [up]}", r"task.X_WGoal.rotation.deg = .*"),
    ("task.pose_error.z=0.1", "task.pose_error.z = 0.1: no such key; known: x, y, yaw"),
    ("task.pose_error.x=near", "task.pose_error.x = 'near'"),
    ("control.torque_gains=3", "control.torque_gains = 3"),
]

# field: values that break its rule
OUT_OF_RANGE = {
    "arm.model": ["''", "nobody"],
    "arm.home": [f"[{NAN}, 0, 0, 0, 0, 0]", f"[0, {INFINITE}, 0, 0, 0, 0]", "[]", "[0, 0]"],
    "arm.frequency": ["0", "-1", NAN, INFINITE],
    "arm.damping_ratio": ["0", "-1", NAN, INFINITE],
    "arm.acceleration": ["0", "-1", NAN, INFINITE],
    "control.set_points": ["[0.08]"],
    "task.grip_threshold": ["0", "-0.01", NAN, INFINITE],
    "task.timeout": ["0", "-1", NAN, INFINITE],
    "task.time_limit": ["0", "-1", NAN, INFINITE],
    "task.force_limit": ["0", "-1", NAN, INFINITE],
    "task.pose_error.x": [NAN, INFINITE],
    "task.pose_error.y": [NAN, INFINITE],
    "task.pose_error.yaw": [NAN, INFINITE],
    "task.object": ["''", "nothing", "workbench"],
    "task.phases.0.name": ["''"],
    "task.phases.0.opening": ["", "0", "-0.01", NAN, INFINITE],
    "task.phases.2.opening": ["0", "-0.01", NAN, INFINITE],
    "task.phases.2.rest": ["-0.01", NAN, INFINITE],
    "task.phases.2.until": ["gripped"],
    "task.phases.1.to": ["objct"],
    "task.phases.1.height": [NAN, INFINITE],
    "task.phases.1.speed": ["0", "-0.5", "1.01", NAN, INFINITE],
    "task.phases.1.posture": ["[0, 0, 0, 0, 0, 0]"],  # beside `to`
    "task.phases.2.posture": ["[0, 0]", f"[0, 0, 0, 0, 0, {NAN}]"],
}


def complaint(override, name=TASK):
    """What loading and building a scenario with one field changed complains about."""
    with pytest.raises(InputError) as caught:
        make_station(load_scenario(name, [override]))
    return caught


@pytest.mark.parametrize(("override", "message"), UNKNOWN_KEYS_AND_TYPES)
def test_unknown_keys_and_wrong_types(override, message):
    assert complaint(override).match(message)


@pytest.mark.parametrize("override", [f"{field}={value}" for field, values in OUT_OF_RANGE.items() for value in values])
def test_out_of_range(override):
    field = override.partition("=")[0]
    for number in range(3):
        field = field.replace(f".{number}.", f"[{number}].")
    owner, _, name = field.rpartition(".")
    before_value = str(complaint(override).value).partition(" = ")[0]
    assert owner in before_value
    assert name in before_value


def test_the_models_to_choose_from_are_named():
    assert complaint("arm.model=leg").match("one of the models: arm, gripper, workbench, box")
    assert complaint("task.object=bx").match("one of the free models: box")


@pytest.mark.parametrize("override", ["arm.model=''", "arm.home=[0, 0, 0, 0, 0, 9]"])
def test_a_task_needs_an_arm_that_can_be_where_it_begins(override):
    assert complaint(override, MOTION).match("one of the models: arm, gripper|give a position within its limits")


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("task={phases: [{name: stay}]}", "arm = None"),
        ("external=[joints]", "there is no arm for ['joints']"),
    ],
)
def test_without_an_arm_nothing_can_move_it(override, message):
    assert message in str(complaint(override, "free_bending").value)


def test_a_task_has_a_phase():
    assert complaint("task.phases=[]").match(r"task.phases = \[\]")


@pytest.mark.parametrize(
    ("override", "field", "value"),
    [
        ("task.phases.0.until=grasped", "task.phases[0].until", "grasped"),
        ("task.phases.2.holds=true", "task.phases[2].holds", True),
        ("task.phases.1.opening=0.08", "task.phases[0].opening", None),
    ],
)
def test_what_a_task_that_leaves_the_gripper_alone_may_not_ask(override, field, value):
    phases = [{"name": name, "posture": [0.0, -1.5, 1.5, 0.0, 0.0, 0.0]} for name in ("a", "b", "c")]
    with refused(field, value):
        load_scenario(TASK, [f"task.phases={phases}", override])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("override", "parts"),
    [
        ("task.X_WGoal.translation=[5, 0, 0.1]", ["task.phases[4]", "to = 'goal'", "out of reach of the arm"]),
        ("models.3.X_PC.translation=[2, 0, 0.04]", ["task.phases[0]", "to = 'object'", "out of reach of the arm"]),
        ("task.phases.1.height=-0.1", ["task.phases[1]", "'descend'", "collides", "workbench"]),
        ("gravity=[0, 0, -900]", ["task.phases[0]", "arm", "effort at rest", "-150 to 150"]),
        ("models.1.parent=arm::tool1", ["models[1]", "parent", "arm::tool1", "no such frame", "tool0"]),
        ("models.1.child=hand", ["models[1]", "child", "hand", "no such frame", "palm"]),
        ("models.1.file=package://soft_gripper/grippers/finger.urdf", ["control", "fingers", "needs two fingers"]),
    ],
)
def test_what_the_arm_cannot_do_is_refused_before_anything_moves(override, parts):
    line = str(complaint(override).value)
    assert "\n" not in line
    for part in parts:
        assert part in line


def test_postures_beyond_the_limits_are_refused():
    line = str(complaint("task.phases.0.posture=[0, 0, 0, 0, 0, 7]", MOTION).value)
    for part in ("task.phases[0]", "wrist_3_joint", "position 7", "-6.283 to 6.283"):
        assert part in line


@pytest.mark.parametrize(
    ("name", "override", "field"),
    [
        (TASK, f"task.X_WGoal.translation=[{NAN}, 0, 0]", "task.X_WGoal"),
        (TASK, f"task.X_WGoal.rotation=!Rpy {{deg: [{NAN}, 0, 0]}}", "task.X_WGoal"),
        (TASK, f"task.X_OG.rotation=!Rpy {{deg: [{NAN}, 0, 0]}}", "task.X_OG"),
        (MOTION, "task.object=nothing", "task.object"),
        (MOTION, "task.phases.0.holds=true", "task"),
    ],
)
def test_never_a_traceback(name, override, field):
    assert field in str(complaint(override, name).value)
