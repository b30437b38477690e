"""Scenario files: found, read with overrides, written out again; and two that run at the ends of the schema."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.schema import Transform
from refusals import refused

from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.extras import added
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario, load_scenario
from soft_gripper.scenario.schema import (
    ArmConfig,
    EstimatorConfig,
    ModelConfig,
    PhaseConfig,
    Scenario,
    SensorConfig,
    StrainErrorsConfig,
    TaskConfig,
)
from soft_gripper.scenario.shipped import scenario_names
from soft_gripper.sensors.pressure_errors import PressureErrors

FOLDER = Path(__file__).parents[1] / "scenarios"
DEFAULTS, EVERYTHING = str(FOLDER / "defaults.yaml"), str(FOLDER / "one_of_everything.yaml")
# A scenario begins at 0 s; not every Drake knows the other field, and logs keep to the sensors' rate.
NO_CHOICE = {"simulator_config.start_time", "simulator_config.publish_every_time_step"}
NO_TASK = "task=null"


def write(folder, text):
    path = folder / "scenario.yaml"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize("source", [*scenario_names(), DEFAULTS, EVERYTHING])
def test_what_is_dumped_loads_again(tmp_path, source):
    text = dump_scenario(load_scenario(source))
    assert dump_scenario(load_scenario(write(tmp_path, text))) == text


@pytest.mark.parametrize("part", ["control", "pressure", "sensor", "nominal"])
def test_a_part_that_is_null_has_its_defaults(part):
    assert getattr(load_scenario("tip_distance_steps", [f"{part}=null"]), part) == getattr(
        load_scenario(DEFAULTS), part
    )


def files_of(scenario):
    """All files that a scenario names."""
    return [*(model.file for model in scenario.models), scenario.nominal.file, scenario.nominal.calibration]


def test_dumped_paths_are_relative_to_where_the_text_is_kept(tmp_path):
    scenario = load_scenario(EVERYTHING)
    files = files_of(scenario)
    text = dump_scenario(scenario, FOLDER)
    assert "file: ../../models/arms/ur5e.urdf" in text
    again = load_scenario(write(tmp_path, dump_scenario(scenario, tmp_path)))
    assert files_of(again) == files
    assert files_of(scenario) == files  # what is dumped stays as it was


@pytest.mark.parametrize(("value", "kept"), [("2.0e-2", "0.02"), ("1", "1"), ("+10 %", "+10 %"), ("'-2.5%'", "-2.5%")])
def test_a_nominal_model_is_a_number_or_a_change(value, kept):
    assert load_scenario("free_bending", [f"nominal.finger.width={value}"]).nominal.finger == {"width": kept}


def test_overrides_take_the_place_of_what_the_file_says():
    overrides = [
        "description=other",
        "sensor.sections=2",
        "pressure.maximum=3e5",
        "pressure.steps.left_finger=[1.0e3, 2.0e3]",
        "models.1.name=renamed",
        "models.0.X_PC.rotation=!Rpy {deg: [0, 0, 90]}",
        "sensor.sections=3",
    ]
    scenario = load_scenario("free_bending", overrides)
    shipped = load_scenario("free_bending")
    assert (scenario.description, scenario.sensor.sections) == ("other", 3)
    assert scenario.pressure.maximum == 3e5
    assert scenario.pressure.steps == shipped.pressure.steps | {"left_finger": [1e3, 2e3]}
    assert [model.name for model in scenario.models] == ["left_finger", "renamed"]
    rotation = scenario.models[0].X_PC.GetDeterministicValue().rotation().matrix()
    np.testing.assert_allclose(rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


def test_steps_of_the_file_are_the_only_ones():
    scenario = load_scenario(DEFAULTS, ["pressure.steps={finger: [1.0]}"])
    assert scenario.pressure.steps == {"finger": [1.0]}


def test_an_entry_of_a_list_is_counted_or_named():
    for key in ("models.1.X_PC.translation", "models.right_finger.X_PC.translation"):
        scenario = changed_scenario("free_bending", {key: [1.0, 2.0, 3.0]})
        assert scenario.models[1].X_PC.translation.tolist() == [1.0, 2.0, 3.0]
        assert scenario.models[0].X_PC.translation.tolist() != [1.0, 2.0, 3.0]


def test_a_scenario_that_is_changed_changes_no_other():
    scenario = load_scenario("box_grasp")
    scenario.models[2].X_PC.translation = [1.0, 0.0, 0.0]
    scenario.plant_config.time_step = scenario.sensor.period = 1.0
    again = load_scenario("box_grasp")
    assert again.models[2].X_PC.translation[0] == 0.0
    assert 1.0 not in (again.plant_config.time_step, again.sensor.period)


def test_changes_are_data_and_stay_as_they_are():
    changes = {"pressure.steps": {"all": [0.0, 1e-7]}, "nominal.finger.width": 0.03, "nominal.finger.length": "+5 %"}
    scenario = changed_scenario("free_bending", changes)
    assert scenario.pressure.steps == {"all": [0.0, 1e-7]}
    assert scenario.nominal.finger == {"width": "0.03", "length": "+5 %"}
    assert changes["nominal.finger.width"] == 0.03


@pytest.mark.parametrize(
    ("override", "field", "value"),
    [
        ("sensor.sections", "argument", "sensor.sections"),
        ("=3", "argument", "=3"),
        ("sensor.sections=[", "sensor.sections", "["),
        ("models.2.name=x", "key", "models.2.name"),
        ("models.first.name=x", "key", "models.first.name"),
        ("models.2={}", "key", "models.2"),
        ("description.deeper=1", "key", "description.deeper"),
        ("description.deeper.still=1", "key", "description.deeper.still"),
    ],
)
def test_wrong_overrides_are_quoted(override, field, value):
    with refused(field, value) as caught:
        load_scenario("free_bending", [override])
    assert str(caught.value).startswith("--set: ")


def test_model_paths_are_relative_to_the_scenario(tmp_path, monkeypatch):
    path = write(tmp_path, "models: [{name: a, file: models/a.urdf}, {name: b, file: package://c/d.urdf}]")
    monkeypatch.chdir("/")
    files = [model.file for model in load_scenario(path).models]
    assert files == [str(tmp_path / "models/a.urdf"), "package://c/d.urdf"]


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"models: [", "is not YAML"),
        (b"", "holds no mapping"),
        (b"\xff\xfe\x00", "cannot be read: it is not a text file"),
    ],
)
def test_files_that_are_no_scenarios(tmp_path, content, complaint):
    path = tmp_path / "scenario.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=complaint) as caught:
        load_scenario(str(path))
    assert str(caught.value).startswith(str(path))


def leaves(config, place=""):
    """Every field below a config, as text: {dotted name: value}."""
    fields = getattr(config, "__dataclass_fields__", None) or [f.name for f in getattr(config, "__fields__", ())]
    if not fields or isinstance(config, Transform):
        return {place: repr(config)}
    below = [leaves(getattr(config, name), f"{place}.{name}".lstrip(".")) for name in fields]
    return {name: value for part in below for name, value in part.items()}


def changed(config, default):
    before = leaves(default)
    return {name for name, value in leaves(config).items() if value != before[name]}


def core_leaves(config):
    """The fields below a config without those that extras add."""
    declared = {name: {f".{each.name}" for each in fields(of)} for part in added("FIELDS") for name, of in part.items()}
    places = {"MeshConfig": "mesh", "TaskConfig": "task", "EstimatorConfig": "estimator"}
    beyond = tuple(f"{places[name]}{field}" for name, found in declared.items() for field in found)
    return {name for name in leaves(config) if not name.startswith(beyond)}


def test_one_of_everything_sets_every_field():
    sensor = SensorConfig(errors=StrainErrorsConfig(), pressure_errors=PressureErrors())
    estimator = EstimatorConfig()
    default = Scenario(arm=ArmConfig(), task=TaskConfig(), sensor=sensor, estimator=estimator)
    scenario = load_scenario(EVERYTHING)
    given_by_phases, of_contact = {"control.set_points", "external"}, {"estimator.compensate_gravity"}
    beside_torque, beside_one_side = {"control.force_limit"}, {"sensor.layout", "sensor.paths"}
    of_soft, of_drake = {"task.squeeze_limit"}, {"directives", "visualization", "engine", "engine_step"}
    left_out = given_by_phases | of_contact | beside_torque | beside_one_side | of_soft | of_drake
    assert changed(scenario, default) == core_leaves(default) - NO_CHOICE - left_out
    # What this scenario, with contact at points, does not have.
    of_surfaces = {"self_contact", "initial_position"}
    for parts, default in ((scenario.models, ModelConfig()), (scenario.task.phases, PhaseConfig())):
        assert set.union(*(changed(part, default) for part in parts)) == core_leaves(default) - of_surfaces


def test_defaults_run():
    scenario = load_scenario(DEFAULTS)
    assert changed(scenario, Scenario()) == {"models"}
    recording = simulate(scenario)
    assert recording["time"][-1] == pytest.approx(scenario.duration)


def test_one_of_everything_runs_in_closed_loop():
    alive = "sensor.errors.dead=[]"
    scenario = load_scenario(EVERYTHING, [NO_TASK, alive, "control.set_points=[0.085, 0.095]"])
    recording = simulate(scenario)
    assert recording["time"][-1] == pytest.approx(len(scenario.control.set_points) * scenario.control.hold)
    left, right = (recording[f"{side}_finger.pressure_command"] for side in ("left", "right"))
    np.testing.assert_array_equal(left, right)
    assert np.abs(left).max() > 0


@pytest.mark.slow
def test_one_of_everything_runs_as_a_task():
    """There is nothing between the fingers: the second phase fails and is given up."""
    scenario = load_scenario(EVERYTHING)
    recording = simulate(scenario)
    assert recording["time"][-1] == pytest.approx(scenario.task.time_limit)
    phases = recording["task.phase"].values
    assert list(dict.fromkeys(phases[phases < len(scenario.task.phases)])) == [0, 1]
    assert recording["task.outcome"][-1] == Outcome.NOTHING_GRASPED
    assert recording["grip.set_point"].values[-1] == scenario.task.phases[0].opening
