"""Every rule of a scenario: what breaks it is refused with the field, the value and what would do."""

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario_file import load_scenario

NAN, INFINITE = ".nan", ".inf"
ONE_FINGER = "models.0.file=package://soft_gripper/grippers/finger.urdf"

UNKNOWN_KEYS = [
    ("sensr.sections=3", "sensr = {.*}: no such key; did you mean 'sensor'"),
    ("sensor.sectons=3", "sensor.sectons = 3: no such key; did you mean 'sections'"),
    ("models.0.nam=x", r"models\[0\].nam = 'x': no such key; did you mean 'name'"),
    ("plant_config.timestep=0", "plant_config.timestep = 0: no such key; did you mean 'time_step'"),
    ("zzz=1", "zzz = 1: no such key; known: description, models, gravity"),
    ("sensor={4: 1}", "sensor = .*"),
]

WRONG_TYPES = [
    ("description=5", "description = 5"),
    ("models={}", "models = {}"),
    ("models=[left]", r"models\[0\] = 'left'"),
    ("gravity=9.81", "gravity = 9.81"),
    ("gravity=[0, 0, down]", r"gravity\[2\] = 'down'"),
    ("control.set_points=0.1", "control.set_points = 0.1"),
    ("control.gains=3", "control.gains = 3"),
    ("control.torque_gains.kii=3", "control.torque_gains.kii = 3: no such key; did you mean 'ki'"),
    ("control.gains.kpp=3", "control.gains.kpp = 3: no such key; did you mean 'kp'"),
    ("pressure=", "pressure = None"),
    ("pressure.settle=soon", "pressure.settle = 'soon'"),
    ("pressure.settle=true", "pressure.settle = True"),
    ("pressure.steps=[0.0]", r"pressure.steps = \[0.0\]"),
    ("pressure.steps.all=0.0", "pressure.steps.all = 0.0"),
    ("pressure.steps.all=[high]", r"pressure.steps.all\[0\] = 'high'"),
    ("sensor.sections=2.5", "sensor.sections = 2.5"),
    ("sensor.sections=true", "sensor.sections = True"),
    ("sensor.one_sided=1", "sensor.one_sided = 1"),
    ("sensor.borders=0.5", "sensor.borders = 0.5"),
    ("sensor.borders=[half]", r"sensor.borders\[0\] = 'half'"),
    ("estimator.alongside=spline", "estimator.alongside = 'spline'"),
    ("estimator.uncertainty.angel=1", "estimator.uncertainty.angel = 1: no such key; did you mean 'angle'"),
    ("sensor.response=[1.0]", r"sensor.response\[0\] = 1.0"),
    ("plant_config.time_step=fast", "plant_config.time_step = 'fast'"),
    ("simulator_config.use_error_control=1", "simulator_config.use_error_control = 1"),
    ("models.0.X_PC.rotation=!Rpz {deg: [0, 0, 0]}", "rotation = .*no such tag here; known: !Rpy"),
]

# field: values that break its rule
OUT_OF_RANGE = {
    "gravity": ["[0, 0]", "[0, 0, 0, 0]", f"[0, 0, {NAN}]", f"[{INFINITE}, 0, 0]"],
    "models": ["[]"],
    "models.0.name": ["''", "right_finger"],
    "models.0.file": ["''"],
    "models.0.segments": ["0", "-1"],
    "pressure.minimum": ["-101326", "210001", NAN],
    "pressure.maximum": [INFINITE],
    "pressure.settle": ["-0.1", NAN, INFINITE],
    "pressure.hold_samples": ["0", "-1"],
    "pressure.time_constant": ["-0.1", NAN, INFINITE],
    "pressure.steps": ["{}"],
    "pressure.steps.all": ["[]", "[-50001]", "[210001]", f"[{NAN}]"],
    "pressure.steps.left_fingr": ["[0.0]"],
    "control.set_points": ["[]", "[0]", "[-0.01]", f"[{NAN}]", f"[{INFINITE}]"],
    "control.hold": ["0", "-1", NAN, INFINITE],
    "control.gains.kp": ["-1", NAN, INFINITE],
    "control.gains.ki": ["-1", NAN, INFINITE],
    "control.gains.kd": ["-1", NAN, INFINITE],
    "control.gains.derivative_filter": ["-0.01", NAN, INFINITE],
    "control.gains.tracking_time": ["0", "-0.1", NAN],
    "control.torque_limit": ["0", "-0.01", NAN, INFINITE],
    "control.torque_gains.kp": ["-1", NAN, INFINITE],
    "control.torque_gains.ki": ["-1", NAN, INFINITE],
    "control.torque_gains.kd": ["-1", NAN, INFINITE],
    "control.torque_gains.derivative_filter": ["-0.01", NAN, INFINITE],
    "control.torque_gains.tracking_time": ["0", "-0.1", NAN],
    "sensor.sections": ["0", "-1", "13"],
    "sensor.borders": ["[0.5]", "[0.2, 0.7, 0.5]", "[0.5, 0.501, 0.7]", "[0.2, 0.5, 1.0]", f"[0.2, 0.5, {NAN}]"],
    "estimator.alongside": ["[arc]", "[spline, spline]", "[arcs]", "['nosuch:make']"],
    "estimator.uncertainty.reading": ["0", "-1.0e-4", NAN, INFINITE],
    "estimator.uncertainty.angle": ["-1.0e-4", NAN, INFINITE],
    "estimator.uncertainty.bend_per_pressure": ["-0.01", NAN],
    "estimator.uncertainty.pressure": ["-1", INFINITE],
    "estimator.uncertainty.load_pressure": ["-1", "0", NAN],
    "estimator.uncertainty.largest_force": ["-1", "0", NAN],
    "estimator.uncertainty.creep": ["-0.1", NAN],
    "estimator.uncertainty.nearest_contact": ["-0.1", "1", NAN],
    "estimator.contact_threshold": ["0", "-0.01", NAN, INFINITE],
    "sensor.period": ["0", "-0.01", NAN, INFINITE],
    "sensor.response": ["[[1, 0]]", "[[1, 0], [2]]", "[[1, 0], [1, 1]]", f"[[1, 0], [2, {NAN}]]"],
    "sensor.type": ["strane", "nosuch:make", "own_blocks:nosuch", "own_blocks:NOT_CALLABLE", "':make'"],
    "estimator.type": ["arc", "nosuch:make", "own_blocks:nosuch", "own_blocks:NOT_CALLABLE", "'own_blocks:'"],
    "nominal.width": ["wide", "0", "-0.02", "-100 %", "10 %", "+ten %", NAN, INFINITE],
    "nominal.sensor_spacing": ["0", "+1 % more"],
    "nominal.file": ["''", "none.urdf", "package://soft_gripper/grippers/three_finger.urdf"],
    "nominal.response": ["[[1, 0]]"],
    "external": ["[pressures]", "[pressure, pressure]", "[pressure, opening]", "[joints]", "[tool]"],
    "plant_config.time_step": ["-0.01", NAN, INFINITE, "0.031"],
    "plant_config.contact_model": ["sticky"],
    "plant_config.discrete_contact_approximation": ["sticky"],
    "plant_config.penetration_allowance": ["0", "-1"],
    "plant_config.stiction_tolerance": ["0", "-1"],
    "simulator_config.integration_scheme": ["euler"],
    "simulator_config.max_step_size": ["0", "-0.01", NAN, INFINITE],
    "simulator_config.accuracy": ["0", "-0.01", NAN, INFINITE],
    "simulator_config.start_time": ["0.5"],
    "simulator_config.publish_every_time_step": ["true"],
}


def complaint(override):
    """What loading and building the free bending with one field changed complains about."""
    with pytest.raises(InputError) as caught:
        make_station(load_scenario("free_bending", [override]))
    return caught


@pytest.mark.parametrize(("override", "message"), UNKNOWN_KEYS + WRONG_TYPES)
def test_unknown_keys_and_wrong_types(override, message):
    assert complaint(override).match(message)


@pytest.mark.parametrize("override", [f"{field}={value}" for field, values in OUT_OF_RANGE.items() for value in values])
def test_out_of_range(override):
    field = override.partition("=")[0].replace("models.0", "models[0]")
    message = str(complaint(override).value)
    owner, _, name = field.rpartition(".")
    assert name in message.partition(" = ")[0]
    # The gains of one PID and not of the other, the nominal model and not the simulated one.
    assert owner in message or not ("torque" in owner or owner == "nominal")


@pytest.mark.parametrize(
    ("name", "overrides", "field", "value"),
    [
        (
            "free_bending",
            ["estimator={contact_threshold: 2e-3, compensate_gravity: false}"],
            "estimator.compensate_gravity",
            False,
        ),
        ("obstructed_inside", [ONE_FINGER, "external=[opening]"], "fingers", ["gripper"]),
        ("tip_distance_steps", ["external=[pressure]"], "external", ["pressure"]),
        ("tip_distance_steps", ["external=[opening]"], "external", ["opening"]),
        ("arm_motion", ["external=[tool]"], "external", ["tool"]),
        ("arm_motion", ["external=[opening]"], "external", ["opening"]),
        (
            "tip_distance_steps",
            [
                *("control.torque_limit=0.1", "control.torque_gains={ki: 1.0}"),
                *("control.force_limit=0.1", "control.force_gains={ki: 1.0}"),
            ],
            "control.force_limit",
            0.1,
        ),
        ("tip_distance_steps", ["control.force_limit=0.5"], "control.force_gains.ki", 0.0),
        ("tip_distance_steps", ["control.force_limit=-0.5"], "control.force_limit", -0.5),
        ("arm_motion", ["task.quiet_band=0"], "task.quiet_band", 0),
        ("arm_motion", ["task=null", "external=[joints, tool]"], "external", ["joints", "tool"]),
    ],
)
def test_what_does_not_go_together(name, overrides, field, value):
    with refused(field, value):
        make_station(load_scenario(name, overrides))


@pytest.mark.parametrize("name", ["plant", "scene_graph", "logs", "WorldModelInstance", "a::b"])
def test_names_that_are_taken_or_cannot_be(name):
    assert complaint(f"models.0.name={name}").match(name)


@pytest.mark.parametrize(
    "override",
    [
        "pressure.minimum=-101325",
        "pressure.settle=0",
        "pressure.hold_samples=1",
        "pressure.time_constant=0",
        "control.gains.derivative_filter=0",
        "control.set_points=[1.0e-3]",
        "pressure.steps.all=[-50000, 210000]",
        "sensor.sections=1",
        "sensor.sections=12",
        "sensor.borders=[0.05, 0.5, 0.95]",
        "estimator.alongside=[spline, gaussian, contact]",
        "estimator.uncertainty={reading: 1.0e-9, angle: 0, bend_per_pressure: 0, pressure: 0, load_pressure: 1}",
        "nominal.density=-99.9 %",
        "nominal.width=0.03",
        "external=[pressure]",
        "estimator.contact_threshold=1.0e-9",
        "plant_config.time_step=0",
        "models.0.segments=4",
        "gravity=[0, 0, 0]",
    ],
)
def test_limits_themselves_are_fine(override):
    make_station(load_scenario("free_bending", [override]))
