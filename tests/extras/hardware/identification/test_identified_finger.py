"""Fits, tests and what cannot be told apart, together; files of fitted fingers, with all else as it was."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from types import SimpleNamespace

import pytest
from identified import HOLLOW, finger_of

from soft_gripper.extras.hardware.identification.identified_finger import (
    _with_ranges,
    read_finger,
    with_finger,
)
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw


@pytest.fixture
def file(tmp_path):
    """A finger file with a chamber."""
    finger_of(HOLLOW, tmp_path)
    return tmp_path / "finger.urdf"


def fitted(finger):
    """The finger with other values of all that a fit may change."""
    ends = {
        end: replace(
            getattr(finger, end),
            youngs_modulus=234567.8,
            density=1111.111,
            chamber_width=0.0123456,
            chamber_thickness=0.00777777,
        )
        for end in ("base", "tip")
    }
    law = PressureLaw((0.0, 1e4 / 3, 2e4), (0.0, 4e3, 7e4 / 3))
    creep = (CreepBranch(1 / 7, 1 / 3), CreepBranch(0.2, 5.5))
    changed = {"length": 0.1 / 0.99, "relaxation_time": 1 / 90, "shear_factor": 6 / 7}
    return replace(finger, **ends, **changed, creep=creep, pressure_law=law)


def numbers(finger):
    """All that a fit may change."""
    of_ends = [
        getattr(end, name)
        for end in (finger.base, finger.tip)
        for name in ("youngs_modulus", "density", "chamber_width", "chamber_thickness")
    ]
    creep = [value for branch in finger.creep for value in (branch.share, branch.time)]
    law = finger.pressure_law
    of_law = [] if law is None else [*law.pressure, *law.effective]
    return [*of_ends, finger.length, finger.relaxation_time, finger.shear_factor, *creep, *of_law]


def test_fitted_finger_reads_back(file):
    finger = fitted(read_finger(file))
    file.write_text(with_finger(file, finger))
    assert numbers(read_finger(file)) == pytest.approx(numbers(finger), rel=5e-6)


def test_all_else_stays(file):
    text = with_finger(file, read_finger(file))
    assert "<!-- a first guess -->" in text
    assert [element.attrib for element in ET.fromstring(text).iter()] == [
        element.attrib for element in ET.fromstring(HOLLOW).iter()
    ]


@pytest.fixture
def sectioned(file):
    """The same finger with two sections, which the file has after the tip."""
    between = "".join(
        f'<section at="{at}" width="0.02" thickness="0.02" material="dragon_skin_10"/><!-- at {at} -->'
        for at in ("0.3", "0.7")
    )
    text = HOLLOW.replace("<sensors", f"{between}<sensors", 1)
    file.write_text(text)
    return file


def test_a_fitted_finger_keeps_its_sections(sectioned):
    before = read_finger(sectioned)
    softer = before.with_sections(
        lambda part: replace(part, youngs_modulus=2e5, chamber_width=0.018 if part.chamber_width else 0.0),
        length=0.1 / 0.99,
    )
    text = with_finger(sectioned, softer)
    sectioned.write_text(text)
    found = read_finger(sectioned)
    assert found == replace(softer, length=found.length)
    assert found.length == pytest.approx(softer.length, rel=5e-6)
    assert "<!-- at 0.3 -->" in text
    written = [element.attrib for element in ET.fromstring(text).iter("section")]
    as_before = {"width": "0.02", "thickness": "0.02", "youngs_modulus": "200000", "density": "1070"}
    assert written == [{"at": at} | as_before for at in ("0.3", "0.7")]


@pytest.mark.parametrize(
    ("changes", "stays"),
    [({"youngs_modulus": 3e5}, False), ({"density": 1e3}, False), ({"chamber_width": 0.011}, True)],
)
def test_material_goes_only_with_what_it_stands_for(file, changes, stays):
    finger = read_finger(file)
    changed = replace(finger, base=replace(finger.base, **changes))
    element = ET.fromstring(with_finger(file, changed)).find("finger")
    assert ("material" in element.find("base").attrib) is stays
    assert ("youngs_modulus" in element.find("base").attrib) is not stays
    assert element.find("tip").attrib["material"] == "dragon_skin_10"


def test_a_set_up_keeps_the_largest_pressure_and_load_of_what_was_fitted():
    """Some recordings have neither pressure nor load."""
    motions = [
        SimpleNamespace(pressure=pressure, load=load)
        for pressure, load in ((2e4, None), (None, SimpleNamespace(mass=0.1)), (3e4, SimpleNamespace(mass=0.05)))
    ]
    setup = Setup(mounting_x=0.01)
    assert _with_ranges(setup, motions) == replace(setup, highest_pressure=3e4, heaviest_load=0.1)
    assert _with_ranges(setup, motions[1:2]) == replace(setup, highest_pressure=0.0, heaviest_load=0.1)
