"""Fingers at rest between springs and tendons of which lengths are pulled in: closed forms, and the plant."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.hardware.identification.tendon_balance import pulled_positions, solve_complementarity
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.path_drive import Tendons
from soft_gripper.fingers.paths import Tendon
from soft_gripper.fingers.spatial_chain import posture, spatial_chain, weights
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario

SECTION = CrossSection(0.012, 0.012, 2e6, 1100.0)
LENGTH, LEVER, STIFFNESS = 0.18, 5e-3, 3e3
IN_SPACE = ("bending", "sideways", "twist")


def pulled_finger(*tendons, yields=IN_SPACE):
    return Finger("robot", LENGTH, SECTION, SECTION, 0.01, yields=yields, tendons=tendons)


def tendon(angle, end=1.0, slack=0.0, name="t"):
    y = LEVER * np.sin(angle)
    place = (LEVER * np.cos(angle),), (y if abs(y) > 1e-9 else 0.0,)
    return Tendon(name, *place, (0.0, end), stiffness=STIFFNESS, slack=slack)


def bends(finger, pulled, gravity=None):
    """The joints' positions by the way in which they yield, of one row."""
    return spatial_chain(finger).separated(pulled_positions(finger, np.array([pulled]), gravity)[0])


@pytest.mark.parametrize("angle", [0.0, 2.0, -1.1])
def test_one_tendon_bends_an_arc_toward_itself(angle):
    """q EI / l = r T and T = k (pulled - slack - r q)."""
    found = bends(pulled_finger(tendon(angle, 0.5, slack=4e-4)), [3e-3])
    compliance = LEVER * 0.5 * LENGTH / SECTION.bending_stiffness
    bend = compliance * STIFFNESS * (3e-3 - 4e-4) / (1 + compliance * STIFFNESS * LEVER)
    np.testing.assert_allclose(found["bending"][:6].sum(), bend * np.cos(angle), rtol=1e-12)
    np.testing.assert_allclose(found["sideways"][:6].sum(), -bend * np.sin(angle), rtol=1e-12)
    np.testing.assert_allclose(found["bending"][6:], 0.0, atol=1e-15)
    np.testing.assert_allclose(found["twist"], 0.0, atol=1e-15)


def test_an_antagonist_under_tension_counts_as_a_second_spring():
    """Both pretensioned by s, the finger bends by  q (EI / l + 2 k r^2) = k r pulled  until one is slack."""
    finger = pulled_finger(tendon(0.0, slack=-2e-3), tendon(np.pi, slack=-2e-3, name="u"))
    joint = SECTION.bending_stiffness / LENGTH
    bend = STIFFNESS * LEVER * 1e-3 / (joint + 2 * STIFFNESS * LEVER**2)
    np.testing.assert_allclose(bends(finger, [1e-3, 0.0])["bending"].sum(), bend, rtol=1e-12)
    assert LEVER * bend < 2e-3  # what the other has to give
    np.testing.assert_allclose(bends(finger, [5e-4, 5e-4])["bending"], 0.0, atol=1e-15)


@pytest.mark.parametrize("guesses", [12, 0], ids=["guessed", "least squares"])
def test_tensions_and_slack_exclude_each_other(guesses, monkeypatch):
    """Whichever way they are found; the conditions decide, and have one solution."""
    monkeypatch.setattr("soft_gripper.extras.hardware.identification.tendon_balance._MAX_GUESSES", guesses)
    random = np.random.default_rng(0)
    levers, wanted = random.normal(size=(40, 7, 5)), random.normal(size=(40, 7))
    matrix = levers @ levers.swapaxes(1, 2) + 0.1 * np.eye(7)
    found = solve_complementarity(matrix, wanted)
    slack = (matrix @ found[..., None])[..., 0] - wanted
    assert (found >= 0).all()
    assert (slack > -1e-10).all()
    np.testing.assert_allclose(found * slack, 0.0, atol=1e-10)
    assert 0.2 < (found > 0).mean() < 0.8


def energy(finger, pulled, gravity, q):
    """Of the springs, the tendons and the weight at joint positions (J,), J."""
    chain, tendons = spatial_chain(finger), Tendons(finger)
    weight = weights(finger, chain, gravity)
    tight = np.maximum(tendons.elongations(chain.separated(q[None]), pulled[None])[0], 0)
    of_weight = -(weight.forces * weight.positions(posture(chain, q))).sum()
    return (
        (chain.interleaved(finger.stiffnesses) * q**2).sum() / 2 + (tendons.stiffness * tight**2).sum() / 2 + of_weight
    )


@pytest.mark.parametrize(("mass", "along"), [(0.02, 9.7), (0.2, 9.7), (0.05, -9.7)], ids=["", "heavy", "upright"])
def test_a_loaded_finger_rests_where_the_energy_is_least(mass, along):
    """No small step away lowers it, and none changes it to first order; upright, only its tendons hold it."""
    ends = [tendon(a, slack=s, name=f"t{i}") for i, (a, s) in enumerate([(0.3, -1e-3), (0.3 + np.pi, 5e-4), (2.0, 0)])]
    finger = replace(pulled_finger(*ends), tip_load=TipLoad(mass, 0.0, 0.0), segments=6)
    pulled, gravity = np.array([3e-3, -3e-3, 2e-3]), np.array([1.0, -0.5, along])
    q = pulled_positions(finger, pulled[None], gravity)[0]
    least, step = energy(finger, pulled, gravity, q), 1e-4
    assert np.abs(q).max() > 0.02
    for away in step * np.eye(len(q)):
        ends = [energy(finger, pulled, gravity, q + sign * away) - least for sign in (1, -1)]
        assert min(ends) > 0
        assert abs(ends[0] - ends[1]) < 1e-3 * sum(ends)


def test_a_row_that_buckles_under_its_weight_is_not_known():
    """And the others are as if they were alone."""
    ends = [tendon(a, slack=s, name=f"t{i}") for i, (a, s) in enumerate([(0.3, -1e-3), (0.3 + np.pi, 5e-4), (2.0, 0)])]
    finger = replace(pulled_finger(*ends), tip_load=TipLoad(0.05, 0.0, 0.0), segments=6)
    pulled, upright = np.array([[-0.1, -0.1, -0.1], [3e-3, -3e-3, 2e-3]]), np.array([1.0, -0.5, -9.7])
    q = pulled_positions(finger, pulled, upright)
    assert np.isnan(q[0]).all()
    np.testing.assert_allclose(q[1], pulled_positions(finger, pulled[1:], upright)[0], atol=1e-9)


@pytest.mark.slow
def test_the_plant_rests_in_the_same_balance(tmp_path):
    """A slanted tendon, pulled in length, bends and twists a finger that its weight bends sideways."""
    text = model_path("package://soft_gripper/grippers/three_chambers.urdf").read_text()
    head, rest = text.split("<!-- 120", 1)
    path = '<tendon name="slanted" at="0 0.9" x="6e-3 -2e-3" y="-8e-3 8e-3" stiffness="2e3" slack="-4e-4"/>'
    (tmp_path / "slanted.urdf").write_text(
        f"{head}{path}</finger>{rest.split('</finger>', 1)[1]}".replace(" stretch", "")
    )
    scenario = load_scenario(
        "three_chambers",
        [
            f"models.finger.file={tmp_path / 'slanted.urdf'}",
            "pressure.steps={all: [0.0]}",
            "tendons.command=pull",
            "tendons.steps.all=[2e-3]",
            "pressure.settle=9.9",
            "pressure.hold_samples=10",
            "gravity=[0.0, 4.0, 3.0]",
        ],
    )
    recording, handle = simulate(scenario), make_station(scenario).fingers[0]
    names = {"bending": "sampled_joint_angles", "sideways": "true_sideways_angles", "twist": "true_twist_angles"}
    found = bends(handle.finger, [2e-3], np.array([0.0, -4.0, -3.0]))  # it hangs upside down
    for way, name in names.items():
        assert np.abs(found[way]).max() > 3e-3
        np.testing.assert_allclose(recording[f"finger.{name}"].values[-1], found[way], atol=2e-5)
