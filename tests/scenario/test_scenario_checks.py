"""What a scenario may hold: the range of every field, and the rules between fields and of what they build.

That each range is kept, and any other value is refused by name, is checked for all schemas in tests/files.
"""

from collections import defaultdict
from dataclasses import fields, is_dataclass, replace

import pytest
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from refusals import refused
from schema_page import scenario_classes

from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.extras import added
from soft_gripper.quantity import rules
from soft_gripper.scenario.checks import checked_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

ONE_FINGER = "models.0.file=package://soft_gripper/grippers/finger.urdf"

RANGES = {
    "above 0": """
        MeshConfig.scale ModelConfig.mass ControlConfig.set_points ControlConfig.hold
        ControlConfig.torque_limit ControlConfig.force_limit PidGains.tracking_time
        JointLimitsConfig.velocity JointLimitsConfig.effort
        ArmConfig.frequency ArmConfig.damping_ratio ArmConfig.acceleration PhaseConfig.opening
        TaskConfig.grip_threshold TaskConfig.quiet_band TaskConfig.timeout TaskConfig.time_limit
        TaskConfig.force_limit TaskConfig.squeeze_limit SensorConfig.period EstimatorConfig.contact_threshold
        StrainErrorsConfig.creep_time StrainErrorsConfig.correlation_time StrainErrorsConfig.quantization
        UncertaintyConfig.reading UncertaintyConfig.load_pressure UncertaintyConfig.largest_force
        UncertaintyConfig.friction
        plant_config.penetration_allowance plant_config.stiction_tolerance simulator_config.max_step_size
        visualization.publish_period""",
    "at least 0": """
        ModelConfig.friction PidGains.derivative_filter PhaseConfig.rest
        PressureConfig.settle PressureConfig.time_constant PressureConfig.leak_time
        TendonConfig.maximum TendonConfig.time_constant
        SensorConfig.seed SensorFaultConfig.section SensorFaultConfig.time DeadSensorConfig.section
        StrainErrorsConfig.gain_error StrainErrorsConfig.offset StrainErrorsConfig.drift
        StrainErrorsConfig.low_frequency_noise StrainErrorsConfig.noise StrainErrorsConfig.delay
        PressureErrors.gain_error PressureErrors.offset PressureErrors.noise PressureErrors.delay
        UncertaintyConfig.angle UncertaintyConfig.bend_per_pressure UncertaintyConfig.pressure UncertaintyConfig.gain
        UncertaintyConfig.bend_variation UncertaintyConfig.offset UncertaintyConfig.drift UncertaintyConfig.creep
        UncertaintyConfig.free_pressure
        plant_config.time_step simulator_config.target_realtime_rate visualization.mouse_interaction_stiffness""",
    "at least 1": "ModelConfig.segments PressureConfig.hold_samples SensorConfig.sections",
    "above 0 and at most 1": "PhaseConfig.speed",
    "at least 0 and at most 1": """
        MeshConfig.color PressureConfig.leaks SensorPathConfig.at
        StrainErrorsConfig.creep StrainErrorsConfig.dropout visualization.initial_proximity_alpha""",
    "at least 0 and below 1": "UncertaintyConfig.nearest_contact",
    "at least 0 and at most 0.14": "StrainErrorsConfig.hysteresis",
    "at least 1e-05": "Scenario.engine_step",
    "at least 1e-09": "simulator_config.accuracy",
    "at least -101325": "PressureConfig.minimum",  # a vacuum
    "at least -1000 and at most 1000": "SensorPathConfig.x_slope SensorPathConfig.y_slope",
    "filled": """
        Scenario.models ModelConfig.file PressureConfig.steps TendonConfig.steps ControlConfig.set_points
        TaskConfig.phases SensorPathConfig.x SensorPathConfig.y SensorPathConfig.at""",
    "a name": "ModelConfig.name PhaseConfig.name SensorPathConfig.name",
    "[least, most]": "StrainErrorsConfig.saturation",
    "3 entries": "Scenario.gravity",
    "4 entries": "MeshConfig.color",
}


def core_fields(schema):
    """The rules of a schema by field, without what extras add."""
    if ".extras." in schema.__module__ or not is_dataclass(schema):
        return {}
    of_extras = [declared[schema.__name__] for declared in added("FIELDS") if schema.__name__ in declared]
    names = {each.name for kind in of_extras for each in fields(kind)}
    return {name: rule for name, rule in rules(schema).items() if name not in names}


def test_the_range_of_every_field():
    found = defaultdict(set)
    for schema in scenario_classes():
        for name, rule in core_fields(schema).items():
            for inner, each in rule.parts.items():
                found[each.limits].add(f"{name}.{inner}")
            found[rule.limits].add(field := f"{schema.__name__}.{name}")
            words = {"filled": rule.filled, "a name": rule.is_name, "[least, most]": rule.span}
            for word in (*(word for word, is_so in words.items() if is_so), f"{rule.length} entries"):
                found[word].add(field)
    assert {words: found[words] for words in found.keys() - {"", "None entries"}} == {
        words: set(names.split()) for words, names in RANGES.items()
    }


# What breaks a rule between fields, or cannot be built: overrides of a scenario, and what is said of them.
BROKEN = {
    "free_bending": {
        "models.0.name=right_finger": "models[0].name = 'right_finger': appears more than once",
        "models.0.name=plant": "models[0].name = 'plant': is the name of a block",
        "models.0.name=logs": "models[0].name = 'logs': is the name of a block",
        "models.0.name=WorldModelInstance": "models[0]: name = 'WorldModelInstance': is taken",
        "models.0.half_space=true; models.0.free=true": "models[0].half_space = True: leave it out",
        "models.0.free=true; models.0.child=mount": "models[0].free = True: leave parent and child out",
        "sections=3": "sections = 3: no such key; did you mean 'sensor.sections'?",
        "sensor.section=3": "sensor.section = 3: no such key; did you mean 'sections'?",
        "control.maximum=3": "no such key; did you mean 'pressure.maximum' or 'tendons.maximum'?",
        "sensor.initial_position=3": "no such key; did you mean 'models.NAME.initial_position'?",
        "time_step=1e-3": "time_step = '1e-3': no such key; did you mean 'plant_config.time_step'?",
        "simulation.time_step=0.01": "no such key; did you mean 'plant_config.time_step'?",
        "simulator.integration_scheme=x": "no such key; did you mean 'simulator_config'?",
        "control.kp=1": "did you mean 'control.gains.kp' or 'control.torque_gains.kp' or 'control.force_gains.kp'?",
        "threshold=1": "did you mean 'task.grip_threshold' or 'estimator.contact_threshold'?",
        "pressure.max=1": "pressure.max = 1: no such key; did you mean 'pressure.maximum'?",
        "sensor.number=4": "sensor.number = 4: no such key; known: type, sections, borders",
        "record.all=true": "record.all = True: no such key; known: truth",
        "dt=1": "dt = 1: no such key; known: desc",
        "models.right_fingr.mass=1": "or a name; did you mean 'right_finger'?",
        "models.0.X_PC.rotation=!Rpz {deg: [0, 0, 0]}": "no such tag here; known: !Rpy",
        "pressure.minimum=210001": "pressure.minimum = 210001.0: must be at most the maximum, 210000 Pa",
        **{
            f"{others}pressure.maximum=-2": "pressure.maximum = -2: contradicts pressure.steps.all[2] = 0.0: must be"
            for others in ("", "sensor.seed=3; models.left_finger.mass=1; ")
        },
        "tendons.steps.all=[0, 3]; tendons.maximum=2": "tendons.steps.all[1] = 3.0: must be from 0 to 2",
        "sensor.period=1e9": "sensor.period = '1e9': contradicts control.hold = ",
        "pressure.steps.left-finger=[1e9]; sensor.seed=1": "pressure.steps.left-finger[0] = 1000000000.0: must",
        "pressure.steps.all=[0, -50001]": "pressure.steps.all[1] = -50001.0: must be within",
        "pressure.steps.left_fingr=[0.0]": "left_fingr = [0.0]: no such finger; did you mean 'left_finger'?",
        "control.hold=0.005": "control.hold = 0.005: must be at least sensor.period",
        "control.set_points=[0.1, 0.1]": "control.set_points[1] = 0.1: is not a step",
        "sensor.sections=13": "sections = 13: must be 1 to 12",
        **{
            f"sensor.borders={borders}": "borders = "
            for borders in ("[0.5]", "[0.2, 0.7, 0.5]", "[0.5, 0.501, 0.7]", "[0.2, 0.5, 1.0]")
        },
        "sensor.layout=four_faces; sensor.one_sided=true": "sensor.one_sided = True: leave it out",
        "sensor.layout=four_faces; sensor.paths=[{name: a}]": "sensor.layout = 'four_faces': leave it out",
        "sensor.faults=[{kind: offset}]": "sensor.faults[0].size = None: must be given",
        "sensor.faults=[{kind: loose, size: 1.1}]": "sensor.faults[0].size = 1.1: must be a share",
        "sensor.faults=[{kind: loose, size: 0}]": "sensor.faults[0].size = 0.0: must be a share",
        "sensor.errors.dead=[{section: 4}]": "sensor.errors.dead[0].section = 4: ",
        "sensor.errors.dead=[{path: left}]": "sensor.errors.dead[0].path = 'left': ",
        "sensor.response=[[1, 0], [1, 1]]": "sensor.response = [[",
        "nominal.response=[[1, 0]]": "nominal.response = [[",
        "estimator.contact_threshold=2e-3; estimator.compensate_gravity=false": "compensate_gravity = False: leave",
        "nominal.finger.sensor_spacing=-100 %": "nominal: finger 'left_finger': sensor_spacing = 0.0: must be above 0",
        "visualization={default_proximity_color: {rgba: [0, 0]}}": "default_proximity_color.rgba = [0, 0]: Rgba must",
        "record.truth=every 0": "record.truth = 'every 0': must be",
        "external=[pressure, pressure]": "external[0] = 'pressure': appears more than once",
        "external=[pressure, opening]": "external = ['pressure', 'opening']: give pressure or opening",
        "external=[tool]": "external = ['tool']: there is no arm for ['tool']",
        "task={phases: [{name: stay}]}": "arm = None: a task moves an arm",
        "simulator_config.start_time=0.5": "simulator_config.start_time = 0.5: must be 0",
        "simulator_config.publish_every_time_step=true": "simulator_config.publish_every_time_step = True: ",
        "plant_config.time_step=0.031": "time_step = 0.031: longer than stable_time_step() = 0.013 s",
        # What would not end.
        "plant_config.time_step=1.0e-12": "plant_config.time_step = 1e-12: 38 s would be 3.8e+13 steps, of",
        "sensor.period=1.0e-12": "sensor.period = 1e-12: 19 s would be 1.9e+13 samples, of at most 5e+05",
        "pressure.hold_samples=4000000000": "steps, of at most 2e+06",
        "simulator_config.target_realtime_rate=1.0e-6": "target_realtime_rate = 1e-06: must be 0, which is",
        "plant_config.time_step=0; simulator_config.max_step_size=1.0e-12": "max_step_size = 1e-12: 38 s would be",
    },
    "obstructed_inside": {f"{ONE_FINGER}; external=[opening]": "fingers = ['gripper']"},
    "tip_distance_steps": {
        "external=[pressure]": "external = ['pressure']: leave out",
        "external=[opening]": "external = ['opening']: leave out",
        "control.torque_limit=0.1": "control.torque_gains.ki = 0.0: must be above 0 to hold",
        "control.force_limit=0.5": "control.force_gains.ki = 0.0: must be above 0 to hold",
        "control.torque_limit=0.1; control.torque_gains.ki=1.0; control.force_limit=0.1; control.force_gains.ki=1.0": (
            "control.force_limit = 0.1: leave it out"
        ),
    },
    "arm_motion": {
        "external=[tool]": "external = ['tool']: leave out",
        "external=[opening]": "external = ['opening']: ",
        "task=null; external=[joints, tool]": "external = ['joints', 'tool']: ",
        "task.object=nothing": "task.object = 'nothing': must be one of the free models: there is none",
        "task.phases.0.holds=true": "task",
        "task.phases.0.posture=[0, 0, 0, 0, 0, 7]": "joint 'wrist_3_joint': position 7 is outside of its limits",
        "arm.model=''": "arm.model = '': must be one of the models: arm, gripper",
        "arm.home=[0, 0, 0, 0, 0, 9]": "arm.home: wrist_3_joint = 9.0: give a position within its limits",
        "models.1.fingers={none: {width: 0.02}}": "none",
    },
    "pick_and_place_box": {
        "arm.model=leg": "arm.model = 'leg': must be one of the models: arm, gripper, workbench, box",
        "arm.home=[0, 0]": "arm: home = [0.0, 0.0]: give a position for each of: shoulder_pan_joint",
        "control.set_points=[0.08]": "control.set_points = [0.08]: leave them out",
        "control.gains.ki=0": "control.gains.ki = 0.0: must be above 0 for a grip",
        "control.torque_limit=0.01; control.torque_gains.ki=1": "must be above task.grip_threshold",
        "task.object=bx": "task.object = 'bx': must be one of the free models: box",
        "task.object=workbench": "task.object = 'workbench': must be one of the free models: box",
        "task.phases.0.opening=": "task.phases[0].opening = None: must be the opening",
        "task.phases.1.posture=[0, 0, 0, 0, 0, 0]": "task.phases[1].posture = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]: leave",
        "task.phases.2.posture=[0, 0]": "task.phases[2] 'close': posture = [0.0, 0.0]: give 6 numbers",
        "task.time_limit=0.01": "task.time_limit = 0.01: must be above sensor.period",
        "task.time_limit=1.0e+9": "plant_config.time_step = 0.005: 1e+09 s would be",
    },
}


def complaint(name: str, overrides: str) -> str:
    """What loading and building a scenario with changed fields complains about."""
    with pytest.raises(InputError) as caught:
        make_station(load_scenario(name, overrides.split("; ")))
    line = str(caught.value)
    assert "\n" not in line
    return line


@pytest.mark.parametrize(("name", "overrides"), [(name, each) for name, broken in BROKEN.items() for each in broken])
def test_what_does_not_go_together_is_refused(name, overrides):
    assert BROKEN[name][overrides] in complaint(name, overrides)


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
    line = complaint("pick_and_place_box", override)
    assert [part for part in parts if part not in line] == []


@pytest.mark.parametrize(
    ("override", "field", "value"),
    [
        ("task.phases.0.until=grasped", "task.phases[0].until", "grasped"),
        ("task.phases.2.holds=true", "task.phases[2].holds", True),
        ("task.phases.1.opening=0.08", "task.phases[0].opening", None),
    ],
)
def test_a_task_that_leaves_the_gripper_alone_may_not_ask_for_a_grip(override, field, value):
    phases = [{"name": name, "posture": [0.0, -1.5, 1.5, 0.0, 0.0, 0.0]} for name in ("a", "b", "c")]
    with refused(field, value):
        load_scenario("pick_and_place_box", [f"task.phases={phases}", override])


def test_more_models_than_can_be_read():
    scenario = load_scenario("box_grasp")
    scenario.models += [replace(scenario.models[-1], name=f"box{i}") for i in range(500)]
    with refused("models", 503):
        checked_scenario("many.yaml", scenario)


def test_contact_approximations_are_those_of_the_installed_drake():
    rule = rules(Scenario)["plant_config"].parts["discrete_contact_approximation"]
    for name in rule.choices:
        AddMultibodyPlant(MultibodyPlantConfig(time_step=0.01, discrete_contact_approximation=name), DiagramBuilder())
