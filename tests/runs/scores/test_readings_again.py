"""Readings made again from a recording: for the sensors of the run they are what its blocks put out at every sample."""

from pathlib import Path

import numpy as np
import pytest
from creeping_fingers import FINGER, write_creeping

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.arcs import Arcs, arcs_from_readings
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.runs.scores.readings import ReadAgain, external_torque_again, read_again, read_recorded, with_sections
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout

SHORT = ["pressure.steps.all=[60e3, 150e3, -30e3]", "pressure.settle=0.1", "pressure.hold_samples=5"]
CURVE = [[0.8, -0.5], [1.0, 0.0], [1.3, 0.2]]
RUNS = {
    "as simulated": ("free_bending", SHORT),
    "in motion": ("arm_motion", ["task.time_limit=0.5"]),
    "one side": ("free_bending", [*SHORT, "sensor.one_sided=true", "sensor.sections=3"]),
    "unequal sections": ("free_bending", [*SHORT, "sensor.sections=3", "sensor.borders=[0.2, 0.5]"]),
    "with the weight": ("obstructed_inside", [*SHORT, "estimator.compensate_gravity=false"]),
    "nominal": (
        "free_bending",
        [*SHORT, "nominal.finger.youngs_modulus='+10 %'", "nominal.finger.sensor_spacing='-5 %'"],
    ),
    "other response": ("free_bending", [*SHORT, f"sensor.response={CURVE}"]),
    "nominal response": ("free_bending", [*SHORT, f"nominal.response={CURVE}"]),
}
INTERVAL = "transverse_force_interval"
Run = tuple[Station, Recording]


def run_of(name: str, overrides: list[str]) -> Run:
    station = make_station(load_scenario(name, overrides))
    return station, run_station(station)


@pytest.fixture(scope="module", params=RUNS.values(), ids=RUNS)
def run(request: pytest.FixtureRequest) -> Run:
    """A station and what a run of it leaves."""
    return run_of(*request.param)


def arcs_of(again: ReadAgain) -> Arcs:
    layout = again.layout
    assert isinstance(layout, SensorLayout)
    return arcs_from_readings(layout, again.readings[again.numbers])


def test_arcs_are_those_of_the_estimator(run: Run) -> None:
    station, recording = run
    for finger in station.fingers:
        arcs = arcs_of(read_again(station, recording, finger, station.scenario.sensor.sections))
        recorded = recording[f"{finger.name}.arcs"].sel(arc=["x", "z", "heading", "length"]).values
        again = np.stack([arcs.start.imag, arcs.start.real, arcs.heading, arcs.length], axis=-1)
        np.testing.assert_allclose(again, recorded, rtol=1e-9, atol=1e-12)
        theta = recording[f"{finger.name}.theta"].values
        np.testing.assert_allclose(arcs.theta, theta, rtol=1e-9, atol=1e-12)


def test_external_torque_is_that_of_the_estimator(run: Run) -> None:
    """Where there are not yet five samples, neither is a number."""
    station, recording = run
    for finger in station.fingers:
        again = read_again(station, recording, finger, station.scenario.sensor.sections)
        torque = external_torque_again(station, recording, finger, again)
        recorded = recording[f"{finger.name}.external_torque"].values
        np.testing.assert_allclose(torque, recorded, rtol=1e-9, atol=1e-12)
        assert np.isfinite(torque[5:]).all()
        assert np.abs(torque[5:]).max() > 1e-5


@pytest.mark.parametrize("estimator", ["arcs", "gaussian"])
def test_a_finger_that_creeps_is_remembered_as_in_its_run(tmp_path: Path, estimator: str) -> None:
    file = write_creeping(FINGER, tmp_path, 0.2, 0.3)
    creeping = [*SHORT, *(f"models.{i}.file={file}" for i in range(2)), f"estimator.type={estimator}"]
    station, recording = run_of("free_bending", creeping)
    finger, name = station.fingers[0], station.fingers[0].name
    again = read_again(station, recording, finger, 4)
    signals = ("driving_torque", "estimated_joint_angles", "external_torque")
    driving, q, torque = (recording[f"{name}.{signal}"].values for signal in signals)
    np.testing.assert_allclose(again.driving(estimator)[again.numbers], driving, atol=1e-7)
    np.testing.assert_allclose(again.shape(estimator).q, q, atol=1e-6)
    found = external_torque_again(station, recording, finger, again, estimator)
    np.testing.assert_allclose(found, torque, atol=1e-6)
    assert np.abs(driving - finger.finger.pressure_torque(again.pressure)[again.numbers]).max() > 5e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["unequal sections", "one side", "with the weight", "nominal", "other response"])
def test_shapes_are_those_of_the_estimators_of_the_run(name: str) -> None:
    """Of all of this project, beside each other, with an uncertainty that is not the usual one."""
    scenario, overrides = RUNS[name]
    kinds = ["spline", "gaussian", "contact"]
    overrides = [*overrides, f"estimator.alongside={kinds}", "estimator.uncertainty={reading: 5.0e-4, angle: 1.0e-3}"]
    station, recording = run_of(scenario, overrides)
    for finger in station.fingers:
        again = read_again(station, recording, finger, station.scenario.sensor.sections)
        for kind in ("arcs", *kinds):
            begin = f"{finger.name}." if kind == "arcs" else f"{finger.name}.{kind}."
            recorded = recording[f"{begin}estimated_joint_angles"].values
            np.testing.assert_allclose(again.shape(kind).q, recorded, rtol=1e-6, atol=1e-9)
        contact = again.shape("contact").contact
        assert contact is not None
        recorded = recording[f"{finger.name}.contact.contact_force"].values
        np.testing.assert_allclose(contact.force, recorded, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", ["as simulated", "in motion"])
def test_from_recorded_readings_the_estimate_is_that_of_the_run(name: str) -> None:
    """From the first sample on, while the base moves too."""
    scenario, overrides = RUNS[name]
    station, recording = run_of(scenario, [*overrides, "estimator.type=contact"])
    for finger in station.fingers:
        recorded = read_recorded(station, recording, finger)
        assert recorded is not None
        q, band = (recording.values(f"{finger.name}.{each}") for each in ("estimated_joint_angles", INTERVAL))
        np.testing.assert_allclose(recorded.shape("contact").q, q, rtol=1e-9, atol=1e-12)
        function = recorded.function("contact")
        assert isinstance(function, ContactShape)
        posterior = function.posterior(*recorded.arguments(function, np.arange(len(q))))
        np.testing.assert_allclose(posterior.transverse_force_interval, band, rtol=1e-9, atol=1e-12)


def test_borders_belong_to_the_number_of_sections_of_the_scenario() -> None:
    """Of the sensors as of those that are assumed in; others are equally long."""
    station = make_station(load_scenario(*RUNS["unequal sections"]))
    layout = SensorLayout(station.fingers[0].finger, 3, borders=(0.2, 0.5))
    assert with_sections(layout, 3) is layout
    for sections in (1, 2, 4):
        other = with_sections(layout, sections)
        assert other.section_ends.tolist() == SensorLayout(layout.finger, sections).section_ends.tolist()
        assert (other.response, other.one_sided) == (layout.response, layout.one_sided)
    recording = run_station(station)
    ends = [read_again(station, recording, station.fingers[0], n).layout.section_ends.tolist() for n in (3, 2)]
    assert ends == [[0, 2, 6, 12], [0, 6, 12]]


def test_the_nominal_model_is_that_of_the_scenario_and_the_sensors_are_not_believed() -> None:
    """Sensors that are assumed to be wider apart than they are find less bend in the same readings."""
    station, recording = run_of("free_bending", SHORT)
    doubting, _ = run_of("free_bending", [*SHORT, "nominal.finger.sensor_spacing='+10 %'"])
    finger, same = station.fingers[0], doubting.fingers[0]
    assert read_again(doubting, recording, same, 4).layout.finger.sensor_spacing == pytest.approx(
        1.1 * finger.finger.sensor_spacing
    )
    theta, nominal = (arcs_of(read_again(s, recording, f, 4)).theta for s, f in ((station, finger), (doubting, same)))
    np.testing.assert_allclose(1.1 * nominal, theta, rtol=1e-9, atol=1e-12)
