"""add_station: a scenario -> its blocks in a diagram. Reads like a table of contents."""

from dataclasses import replace

from pydrake.geometry import Meshcat
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.commanding import add_arm, add_drive_commands
from soft_gripper.diagrams.private_run import fuse_loop, remove_unread_blocks
from soft_gripper.diagrams.scene import add_copy, add_plant
from soft_gripper.diagrams.signal_logs import SignalLogs, add_logs
from soft_gripper.diagrams.station_parts import Station, StationParts
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.plant_signals import add_plant_signals
from soft_gripper.diagrams.wiring.sensing import SensingConfig, add_sensing
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import MakeEstimator
from soft_gripper.files.notes import collect_notes
from soft_gripper.registry import name_of
from soft_gripper.scenario.checks import check_finger_names, checked_scenario
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import MakeSensor


def make_station(
    scenario: Scenario,
    meshcat: Meshcat | None = None,
    *,
    make_sensor: MakeSensor | None = None,
    make_estimator: MakeEstimator | None = None,
) -> Station:
    """Builds a diagram that contains only the blocks of a scenario; see `add_station`.

    Every port of it, and of every block in it, can be read at any time.

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    builder = DiagramBuilder()
    visuals = meshcat is not None  # the only viewer that can be added
    station = add_station(
        builder, scenario, meshcat, make_sensor=make_sensor, make_estimator=make_estimator, visuals=visuals
    )
    return _build_station(builder, station, add_logs(builder, station.signals, station.scenario.sensor.period))


def make_private_station(
    scenario: Scenario, meshcat: Meshcat | None = None, composed: bool = True, like: StationParts | None = None
) -> Station:
    """Builds a station for runs without readers of its diagram: faster, with the same recording.

    Blocks that no other reads are left out of its diagram, and its outputs are the signals that it still computes;
    unless they are `composed`, sensors, estimation and grip control stay diagrams of blocks. `like` as for
    `add_station`.

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    builder = DiagramBuilder()
    station = add_station(builder, scenario, meshcat, visuals=meshcat is not None, composed=composed, like=like)
    period = station.scenario.sensor.period
    logs = add_logs(builder, station.signals, period)
    station.signals, removed = remove_unread_blocks(builder, station.signals)
    if composed:
        station.signals = fuse_loop(builder, station.signals)
    return replace(_build_station(builder, station, logs), removed=removed)


def _build_station(builder: DiagramBuilder, station: StationParts, logs: SignalLogs) -> Station:
    for name, command in station.inputs.items():
        builder.ExportInput(command, name)
    for name, signal in station.signals.items():
        builder.ExportOutput(signal, name)
    diagram = builder.Build()
    diagram.set_name("station")
    station.check(diagram)
    return Station(diagram, station, logs)


def add_station(
    builder: DiagramBuilder,
    scenario: Scenario,
    meshcat: Meshcat | None = None,
    *,
    make_sensor: MakeSensor | None = None,
    make_estimator: MakeEstimator | None = None,
    visuals: bool = True,
    composed: bool = False,
    like: StationParts | None = None,
) -> StationParts:
    """Adds the blocks of a scenario to a diagram, to which you can add your own blocks and logs.

    ::

        pressure_steps -> {model}.pressure_drive -> plant -> {finger}.sensors -> {finger}.estimation -> signals
        or grip_control ----^                         ^ |                           |    |
               ^------------------------------------- | | --------------------------+    v
               +-- task, steps or an input            | +--------------------> {finger}.scoring -> signals
                     +---> {arm}: desired state ------+

    Args:
        builder: builder of any diagram.
        scenario: defines the models, drive, sensors and estimators.
        meshcat: shows the scene and the estimates.
        make_sensor, make_estimator: make user blocks that replace those named in the scenario.
        visuals: see `add_plant`; False is for a diagram in which no Meshcat or camera looks at the fingers.
        composed: sensors and estimation are one block each, not diagrams of blocks; the ports are the same.
        like: of another diagram, with the same models but for poses of free ones; its plant is copied, not read anew.

    Raises:
        InputError: if a part of the scenario cannot be built, or the diagram already has a plant.
    """
    _check_no_plant(builder)
    with collect_notes() as notes:
        scenario = checked_scenario("scenario", scenario)
        nominal = read_nominal_model(scenario.nominal)
        if like is None:
            scene = add_plant(builder, scenario, visuals)
        else:
            scene = add_copy(builder, like.scene, scenario.models)
            notes += [note for note in like.notes if note not in notes]
        made_by = (name_of(make_sensor, scenario.sensor.type), name_of(make_estimator, scenario.estimator.type))
        check_finger_names("scenario", (finger.finger.name for finger in scene.fingers))
        plant, scene_graph, fingers, deformables, _, mimics = scene
        station = StationParts(scenario, plant, scene_graph, tuple(fingers), deformables, mimics, *made_by)
        drive = add_pressure_drive(builder, scene.fingers, scenario.pressure, scenario.tendons)
        station.signals |= {f"{model}.actuation": torque for model, torque in drive.actuations.items()}
        sensing = SensingConfig(
            scenario.sensor, scenario.estimator, nominal, make_sensor, make_estimator, scenario.record, composed
        )
        station.signals |= add_sensing(builder, scene.fingers, drive.pressures, sensing, drive.tensions)
        set_point = add_drive_commands(builder, station, drive)
        if scenario.arm is not None:
            add_arm(builder, station, scenario.arm, set_point)
        free_names = [model.name for model in scenario.models if model.free]
        arm = None if scenario.arm is None else scenario.arm.model
        wrenches = scenario.record.truth != "none"
        station.signals |= add_plant_signals(builder, scene, free_names, arm, wrenches)
        if meshcat is not None:
            from soft_gripper.diagrams.view.meshcat_view import add_meshcat_view

            add_meshcat_view(builder, scene, station.signals, meshcat, scenario)
        station.notes += notes
    return station


def _check_no_plant(builder: DiagramBuilder) -> None:
    """Checks that there is no other station: Drake aborts the process if two blocks have the same name."""
    for name in ("plant", "scene_graph"):
        if builder.HasSubsystemNamed(name):
            expected = "is already in the diagram; put all models into one scenario, or call make_station for each"
            raise InputError("add_station", "builder", name, expected)
