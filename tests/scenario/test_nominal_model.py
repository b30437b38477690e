"""The nominal model: values, changes and other files; and its effect on the estimates."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from finger_plants import free_bending
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import NominalConfig

TWO = "package://soft_gripper/grippers/two_finger.urdf"


def nominal(finger, changes=MappingProxyType({}), **config):
    return read_nominal_model(NominalConfig(dict(changes), **config)).finger(finger)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("width", 0.026), ("thickness", 0.026), ("youngs_modulus", 4e5), ("density", 1300.0)],
        *[("chamber_width", 7e-3), ("chamber_thickness", 7e-3), ("chamber_center", -7e-4)],
        *[("layer_thickness", 3e-4), ("layer_modulus", 2e8), ("layer_shear_modulus", 1e8)],
    ],
)
def test_changes_of_the_cross_section_are_for_base_and_tip(tapered_finger, name, value):
    for text, change in ((repr(value), lambda old: value), ("+10 %", lambda old: 1.1 * old)):
        sections = {"base": tapered_finger.base, "tip": tapered_finger.tip}
        ends = {end: replace(section, **{name: change(getattr(section, name))}) for end, section in sections.items()}
        assert nominal(tapered_finger, {name: text}) == replace(tapered_finger, **ends)


@pytest.mark.parametrize("text", ["10", "0.1"])
def test_a_forgotten_percent_sign_is_no_modulus(tapered_finger, text):
    with refused("youngs_modulus"):
        nominal(tapered_finger, {"youngs_modulus": text})


@pytest.mark.parametrize("file", ["package://soft_gripper/grippers/finger.urdf", TWO])
def test_a_file_gives_the_finger_of_that_name_or_its_only_one(shipped_finger, file):
    """With as many segments as are simulated; changes come on top."""
    simulated = replace(shipped_finger, name="right_finger", length=0.5, segments=7, sensor_spacing=0.01)
    expected = replace(shipped_finger, name="right_finger", segments=7, relaxation_time=0.013)
    assert nominal(simulated, {"relaxation_time": "+100 %"}, file=file) == expected


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"finger": {"width": "wide"}}, "nominal: width = 'wide': must be a number, or a change such as \"+10 %\""),
        ({"finger": {"length": "-1"}}, "nominal: finger 'tapered': length = -1.0"),
        ({"file": TWO}, "holds no finger 'tapered', nor a single one; it has left_finger, right_finger"),
        ({"file": "package://soft_gripper/arms/ur5e.urdf"}, "it has none"),
    ],
)
def test_what_cannot_be_believed(tapered_finger, changes, message):
    with pytest.raises(InputError) as caught:
        read_nominal_model(NominalConfig(**changes)).finger(tapered_finger)
    assert message in str(caught.value)


PRESSURE = 60e3  # Pa


@pytest.fixture(scope="module")
def settled():
    """What is recorded at the end of a free bending under PRESSURE without weight, by nominal model."""

    def run(*nominals):
        scenario = free_bending([PRESSURE], 1.5, "gravity=[0, 0, 0]", *(f"nominal.{nominal}" for nominal in nominals))
        data = simulate(scenario).data.isel(time=-1)
        return lambda signal: data[f"left_finger.{signal}"].values

    return run


def test_readings_are_those_of_the_simulated_finger(settled):
    true, wrong = (
        settled(),
        settled("finger.sensor_spacing=+10 %", "finger.youngs_modulus=+10 %", "response=[[1, 0], [2, 2]]"),
    )
    for signal in ("strain", "extension_ratio", "sampled_joint_angles"):
        np.testing.assert_array_equal(wrong(signal), true(signal))
