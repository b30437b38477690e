"""Estimators alongside another: what they estimate is what they would as the estimator of the run, and nothing else."""

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["pressure.steps.all=[90e3]", "pressure.settle=0.2", "pressure.hold_samples=1", "sensor.sections=2"]
SHORT += ["sensor.borders=[0.4]", "estimator.uncertainty.reading=3e-4", "nominal.finger.youngs_modulus='+5 %'"]
KINDS = ["gaussian", "spline", "contact", "own_blocks:mean_bend"]


def run_of(*overrides):
    return run_station(make_station(load_scenario("obstructed_inside", [*SHORT, *overrides])))


@pytest.fixture(scope="module")
def alone():
    """With the estimator of the scenario, `arcs`, alone."""
    return run_of()


@pytest.fixture(scope="module")
def recording():
    """With four more."""
    return run_of(f"estimator.alongside={KINDS}")


def signals_of(recording, finger, kind):
    """The signals of a finger by one of the estimators alongside, by their names alone."""
    begin = f"{finger}.{kind}."
    return {name.removeprefix(begin): recording[name] for name in recording.data if name.startswith(begin)}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_it_estimates_what_it_would_as_the_estimator_of_the_run(recording, kind):
    run = run_of(f"estimator.type={kind}")
    for finger in ("left_finger", "right_finger"):
        for name, values in signals_of(recording, finger, kind).items():
            np.testing.assert_array_equal(values.values, run[f"{finger}.{name}"].values)


def test_the_run_stays_as_it_is_without_them(recording, alone):
    kinds = tuple(f".{kind}." for kind in KINDS)
    own = {name for name in recording.data if not any(kind in name for kind in kinds)}
    assert own == set(alone.data)
    for name in own:
        np.testing.assert_array_equal(recording[name].values, alone[name].values)


def test_what_it_learns_of_the_drive_is_kept_and_what_it_is_given_is_not():
    found = signals_of(run_of("estimator.alongside=[recursive]"), "left_finger", "recursive")
    assert [name for name in found if name.endswith("driving_torque")] == ["effective_driving_torque"]


def test_a_recording_with_them_is_kept_and_read(recording, tmp_path):
    """Whatever characters the name of a user's function has."""
    part = recording.data[[name for name in recording.data if "own_blocks:" in name]]
    Recording(part).save(tmp_path / "run.nc")
    again = Recording.load(tmp_path / "run.nc")
    assert "left_finger.own_blocks:mean_bend.pose_error" in again.data
    assert again.data.equals(part)


@pytest.mark.parametrize(
    ("overrides", "complaint"),
    [
        (
            ["estimator.alongside=[gauss]"],
            "estimator.alongside = 'gauss': did you mean 'gaussian'?",
        ),
        (
            ["estimator.alongside=['own_blocks:warm_sensor']"],
            "estimator.alongside = 'own_blocks:warm_sensor': failed: ",
        ),
        (
            ["estimator.alongside=[spline, spline]"],
            "estimator.alongside[0] = 'spline': is an estimator of this scenario al",
        ),
        (
            ["estimator.alongside=[gaussian, arcs]"],
            "estimator.alongside[1] = 'arcs': is an estimator of this scenario already",
        ),
    ],
)
def test_what_cannot_stand_beside(overrides, complaint):
    with pytest.raises(InputError) as caught:
        make_station(load_scenario("free_bending", overrides))
    assert complaint in str(caught.value)
