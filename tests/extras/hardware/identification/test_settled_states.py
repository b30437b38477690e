"""Settled states of tendon-driven fingers: a synthetic twin, what is fitted to it, and the published robots."""

from dataclasses import replace

import numpy as np
import pytest
from hardware_files import published
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.commands.printing import print_identified_states
from soft_gripper.extras.hardware.identification import settled_states as module
from soft_gripper.extras.hardware.identification.free_parameters import Model, free_parameters
from soft_gripper.extras.hardware.identification.identified_finger import read_finger, with_finger
from soft_gripper.extras.hardware.identification.model_band import learned_band
from soft_gripper.extras.hardware.identification.settled_states import (
    SettledStates,
    fit_states,
    identify_states,
    predicted_markers,
    resting_positions,
    settled_states,
    slack_tendons,
    state_doubts,
    state_errors,
    states_figure,
)
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.identification.tendon_balance import pulled_positions
from soft_gripper.extras.hardware.recording_schema import PoseConfig, load_description
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.files.notes import collect_notes
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.paths import Tendon
from soft_gripper.scenario.model_files import model_path

SECTION = CrossSection(0.012, 0.012, 2e6, 1100.0)
LEVER = 5e-3
FREE = ["tendon.angle", "tendon.slack", "tendon.stiffness", "dry_friction"]
NOISE = 1e-4  # m


def robot(angles, slacks, stiffnesses):
    """Three tendons to the middle of a finger, and three to its end."""
    ends = np.repeat([0.5, 1.0], 3)
    tendons = [
        Tendon(f"t{i}", (LEVER * np.cos(a),), (LEVER * np.sin(a),), (0.0, end), stiffness=k, slack=s)
        for i, (a, end, s, k) in enumerate(zip(angles, ends, slacks, stiffnesses, strict=True))
    ]
    return Finger(
        "robot",
        0.18,
        SECTION,
        SECTION,
        0.01,
        segments=6,
        yields=("bending", "sideways", "twist"),
        tendons=tuple(tendons),
    )


TRUE = Model(
    robot(
        np.radians([3, 118, -125, 34, 151, -88]),
        [-2e-4, 1e-4, 3e-4, -1e-4, 1e-3, -3e-4],
        [5e3, 4e3, 4.5e3, 3e3, 5e3, 4e3],
    ),
    Setup(dry_friction=0.03),
)
GUESS = robot(np.radians([0, 120, -120, 30, 150, -91]), [0.0] * 6, [4e3] * 6)


def states_of(model=TRUE, rows=120, seed=0):
    """One family pulls one tendon at a time, the other pulls one of each three at once; noise on the marker."""
    random, pulled = np.random.default_rng(seed), np.full((rows, 6), -1e-3)
    families = np.where(np.arange(rows) % 2, "both", "single")
    for row, family in zip(pulled, families, strict=True):
        first, last = random.integers(3), 3 + random.integers(3)
        which = [first, last] if family == "both" else [random.choice([first, last])]
        row[which] = random.uniform(0, 8e-3, len(which))
    states = SettledStates("made", pulled, np.zeros((rows, 1, 3)), np.array([[0, 0, 8e-3]]), families, np.zeros(3))
    markers, _ = predicted_markers(model.finger, states, resting_positions(model, states))
    placed = markers + np.array([0.01, -0.02, 0.3]) + random.normal(0, NOISE, markers.shape)
    return replace(states, markers=placed)


@pytest.fixture(scope="module")
def found():
    return identify_states(GUESS, FREE, [states_of()], [states_of(seed=1)], HereExecutor())


def test_what_made_the_states_is_found(found):
    """Within four standard deviations, of noise that is independent; and the states of another day are predicted."""
    free = free_parameters(TRUE.finger, FREE, [])
    true = np.append(free.start[:-1], TRUE.setup.dry_friction)
    assert (np.abs(found.fit.x - true) < 4 * found.confidence.std).all()
    assert (found.confidence.std[:6] < np.radians(0.5)).all()
    assert not found.confidence.undetermined
    rms = {(score.role, score.family): score.rms_mm for score in found.scores}
    assert set(rms) == {("fit", "all"), ("test", "all"), *(("left out", name) for name in ("all", "both", "single"))}
    noise = 1e3 * NOISE * np.sqrt(3)
    np.testing.assert_allclose([rms["fit", "all"], rms["test", "all"]], noise, rtol=0.1)
    assert rms["left out", "both"] < 1.2 * noise


def test_families_left_out_are_predicted_without_them(found, monkeypatch):
    """And each is placed as a recording of its own: markers of one that are all shifted harm the other's fit alone."""
    fitted = []

    def remembered(free, recordings, rows=None, *others, **more):
        families = recordings[0].families
        fitted.append([list(families if rows is None else families[rows[0]])])
        return fit_states(free, recordings, rows, *others, **more)

    monkeypatch.setattr(module, "fit_states", remembered)
    states = states_of(rows=60)
    shifted = states.families == "both"
    states.markers[shifted] += 0.02
    again = identify_states(GUESS, ["tendon.stiffness"], [states], [], HereExecutor())
    assert [set(rows[0]) for rows in fitted] == [{"both", "single"}, {"single"}, {"both"}]
    np.testing.assert_allclose(again.left_out[0][shifted].mean(axis=(0, 1)), 0.0, atol=1e-12)
    assert np.abs(again.errors[0][shifted].mean(axis=(0, 1))).min() > 5e-3


def test_slopes_are_those_of_the_errors(monkeypatch):
    """By central differences over every free parameter, under gravity, which makes the balance nonlinear."""
    states = replace(states_of(rows=8), gravity=np.array([1.0, 2.0, -3.0]))
    free = free_parameters(TRUE.finger, ["tendon.angle", "tendon.slack", "tendon.stiffness", "length"], [])
    keep = np.arange(8) > 1
    monkeypatch.setattr(module, "_DIFFERENCE_STEP", 1e-3)
    slopes = module.marker_slopes(free, free.start, states, keep)
    for column, step in zip(slopes.T, np.diag(1e-3 * free.scales), strict=True):
        ends = [state_errors(free.build_model(free.start + sign * step), states, keep)[keep] for sign in (1, -1)]
        np.testing.assert_allclose(
            column, (ends[0] - ends[1]).ravel() / (2 * step.max()), atol=0.01 * np.abs(column).max()
        )


def test_dry_friction_lags_behind_and_follows():
    """One tendon in and out: the bend stays behind by the friction, and stands still where it turns."""
    pull = np.concatenate([np.linspace(0, 5e-3, 40), np.linspace(5e-3, 0, 40)])
    finger = robot([0.0, 2.1, -2.1, 0.5, 2.6, -1.6], [0.0] * 6, [4e3] * 6)
    pulled = np.full((80, 6), -5e-3)
    pulled[:, 0] = pull
    states = SettledStates("in and out", pulled, np.zeros((80, 1, 3)), np.zeros((1, 3)), np.full(80, ""), np.zeros(3))
    free = pulled_positions(finger, pulled).sum(axis=1)
    held = resting_positions(Model(finger, Setup(dry_friction=0.06)), states).sum(axis=1)
    np.testing.assert_allclose(held[20:40], free[20:40] - 0.03, atol=1e-12)  # half of the segments bend
    np.testing.assert_allclose(held[60:75], free[60:75] + 0.03, atol=1e-12)
    np.testing.assert_allclose(held[40:42], held[39], atol=1e-12)


def test_backlash_is_passed_where_a_motor_turns_back_between_two_rows():
    """One tendon in by 5 mm and out again, of which only the ends are rows: it lags by the backlash."""
    wound = 5e-3 - np.abs(np.linspace(-5e-3, 5e-3, 21))[:, None] * np.ones(6)
    nothing = np.zeros((2, 1, 3))
    ends = {"pulled": wound[[0, 20]], "time": np.array([0.0, 2.0]), "winding": (np.linspace(0, 2, 21), wound)}
    states = SettledStates("in and out", markers=nothing, places=nothing[0], families=None, gravity=None, **ends)
    np.testing.assert_allclose(states.delayed_lengths(0.0, 1e-3), [[0.0] * 6, [1e-3] * 6], atol=1e-12)
    np.testing.assert_allclose(states.delayed_lengths(1.0, 1e-3)[1], [4e-3] * 6, atol=1e-12)
    model = Model(TRUE.finger, Setup(backlash=1e-3))
    np.testing.assert_allclose(
        resting_positions(model, states)[1], pulled_positions(TRUE.finger, np.full((1, 6), 1e-3))[0], atol=1e-12
    )


def test_the_file_of_the_fitted_finger(found, tmp_path):
    """Only the tendons' numbers change."""
    file = model_path("package://soft_gripper/recordings/tendon_robot_v4.urdf")
    finger = read_finger(file)
    free = free_parameters(finger, FREE, [])
    fitted = free.build_model(free.start + 0.1 * free.scales).finger
    (tmp_path / "fitted.urdf").write_text(with_finger(file, fitted))
    again = read_finger(tmp_path / "fitted.urdf")
    for tendon, wanted, before in zip(again.tendons, fitted.tendons, finger.tendons, strict=True):
        np.testing.assert_allclose([*tendon.x, *tendon.y], [*wanted.x, *wanted.y], rtol=1e-5, atol=1e-9)
        assert tendon.slack == pytest.approx(wanted.slack)
        assert tendon.stiffness == pytest.approx(wanted.stiffness, rel=1e-5)
        assert tendon.stiffness != before.stiffness
    assert replace(again, tendons=finger.tendons) == finger


COLUMNS = "time,what,a_mm,b_mm,tip_x,tip_y,tip_z"
DESCRIBED = """
event: settled
length: 0.18
tendons: {columns: {t0: a_mm, t1: b_mm}, unit: mm}
markers: {unit: mm, bodies: {tip: [tip]}, places: {tip: [0, 0, 0.008]}}
labels: {column: what, family: "{word}_"}
frame: {origin: [0, 0, 0]}
"""
TWO = replace(GUESS, tendons=GUESS.tendons[:2])


def read(folder, rows, described=DESCRIBED, finger=TWO):
    (folder / "made.csv").write_text("\n".join([COLUMNS, *rows]) + "\n")
    (folder / "made.yaml").write_text(described)
    (recording,) = find_recordings([str(folder / "made.csv")])
    return settled_states(recording, finger)


@pytest.mark.parametrize(
    ("poses", "pressures", "said"),
    [(True, False, "not poses: name the columns"), (False, True, "a file for each constant pressure")],
)
def test_recordings_that_are_not_read_are_told_how_they_would_be(tmp_path, poses, pressures, said):
    (tmp_path / "made.csv").write_text(f"{COLUMNS}\n0,in_1,1,-2,10,20,150\n1,in_2,2,-2,11,21,151\n")
    (tmp_path / "made.yaml").write_text(DESCRIBED)
    (recording,) = find_recordings([str(tmp_path / "made.csv")])
    if poses:
        pose = PoseConfig(["x", "y", "z"], ["w", "i", "j", "k"])
        recording = replace(recording, config=replace(recording.config, markers=None, poses={"tip": pose}))
    if pressures:
        recording = replace(recording, pulled={}, pressures=np.zeros((2, 1)))
    with pytest.raises(InputError, match=said):
        settled_states(recording, TWO)


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("t1: b_mm", "t9: b_mm", "tendons.columns"),
        ("t1: b_mm", "t1: c_mm", "tendons.columns"),
        ("unit: mm}\nmarkers", "unit: m}\nmarkers", "tendons.unit"),
        ("unit: mm}\nmarkers", "unit: deg}\nmarkers", "tendons.radius"),
        ("unit: mm}\nmarkers", "unit: mm, radius: 0.01}\nmarkers", "tendons.radius"),
        ("t1: b_mm}", "t1: b_mm}, antagonists: {t1: a_mm}", "tendons.antagonists.t1"),
        ("0.008]}", "0.008]}, at: {top: 0.5}", "markers.at.top"),
        ("length: 0.18", "length: 0.18\nevery: 2", "rows"),
        ("column: what", "column: who", "labels.column"),
        ("places: {tip", "places: {top", "markers.places.top"),
        ("[0, 0, 0.008]", "[0, 0.008]", "markers.places.tip"),
        (", places: {tip: [0, 0, 0.008]}", "", "markers.places"),
        ("tendons: {columns: {t0: a_mm, t1: b_mm}, unit: mm}", "", "tendons"),
    ],
)
def test_descriptions_that_are_refused(tmp_path, old, new, field):
    assert old in DESCRIBED
    with refused(field):
        read(tmp_path, ["0,in_1,1,-2,10,20,150", "1,in_2,2,-2,11,21,151"], DESCRIBED.replace(old, new))


@pytest.mark.published
@pytest.mark.parametrize(("robot", "fitted", "left_out"), [("v4", 4.0, 3.9), ("v6", 7.9, 7.5)])
def test_published_robots(robot, fitted, left_out):
    """The errors that the page on identification states; families left out are predicted nearly as well."""
    folder, name = published("tendon_robots"), f"tendon_robot_{robot}"
    config = load_description(name)
    (recording,) = find_recordings([str(folder / f"{robot}_train.csv")], name)
    finger = read_finger(model_path(config.finger))
    found = identify_states(finger, FREE, [settled_states(recording, finger)], [], HereExecutor())
    rms = {(score.role, score.family): score.rms_mm for score in found.scores}
    assert (round(rms["fit", "all"], 1), round(rms["left out", "all"], 1)) == (fitted, left_out)


def test_a_step_to_an_impossible_finger_is_not_taken(monkeypatch):
    """The search goes on from before it, and ends where it would have."""
    states, free = states_of(rows=30), free_parameters(TRUE.finger, ["tendon.stiffness"], [])
    rows, start = [np.arange(30) > 4], 0.9 * free.start
    expected, tried = fit_states(free, [states], rows, starts=start).x, []

    def impossible_at_first(model, *others):
        tried.append(model)
        if len(tried) == 3:
            raise InputError("finger", "field", 0, "another")
        return state_errors(model, *others)

    monkeypatch.setattr(module, "state_errors", impossible_at_first)
    np.testing.assert_allclose(fit_states(free, [states], rows, starts=start).x, expected, rtol=1e-2)
    assert len(tried) > 3


def unbalanced(states, rows):
    """States with a row that no finger is in balance with: tendons that are pulled in by metres."""
    pulled = states.pulled.copy()
    pulled[rows] = 1e3
    return replace(states, pulled=pulled, gravity=np.array([0.0, 0.0, -9.81]))


def test_rows_without_a_balance_are_left_out_and_named():
    """They change nothing of the result but the number of the rows; and the search says how many there are."""
    whole = replace(states_of(rows=16), families=np.full(16, ""), time=np.arange(16.0))
    lost, steps, keep = unbalanced(whole, [3, 9]), [], np.isin(np.arange(16), [3, 9], invert=True)
    without = replace(
        lost, pulled=lost.pulled[keep], markers=lost.markers[keep], families=lost.families[keep], time=None
    )
    with collect_notes() as notes:
        found = identify_states(GUESS, ["tendon.stiffness"], [lost], [], HereExecutor(), report=steps.append)
    expected = identify_states(GUESS, ["tendon.stiffness"], [without], [], HereExecutor())
    np.testing.assert_allclose(found.fit.x, expected.fit.x, rtol=1e-3)
    assert [note.element for note in notes] == ["row at 3 s", "row at 9 s"]
    assert found.scores[0].rows == 14
    assert found.scores[0].rms_mm == pytest.approx(expected.scores[0].rms_mm, rel=1e-2)
    assert {step.missing for step in steps} == {3 * 2}
    assert steps[-1].error < steps[0].error
    assert len(states_figure(found).axes) == 3


def test_what_nothing_determines_is_predicted_by_the_best_fit(capsys):
    """Without weight the density changes nothing: families left out are predicted all the same, and it is said."""
    states = states_of(rows=30)
    found = identify_states(TRUE.finger, ["density"], [states], [], HereExecutor())
    (density,) = found.confidence.undetermined
    assert density.value == pytest.approx(SECTION.density)
    assert "left out" in capsys.readouterr().err
    one = states.families == "both"
    expected = state_errors(found.model, states, one)[one]
    np.testing.assert_allclose(found.left_out[0][one], expected, atol=1e-12)
    assert state_doubts(found)[0].startswith("no key is determined")
    print_identified_states(found)
    assert "WARNING: no key is determined" in capsys.readouterr().out
    learned_band(found)


def test_tendons_that_pull_the_other_way_are_refused():
    """All are let out where the motors pull them in: no row tightens any."""
    states = states_of(rows=30)
    with refused("tendons", ", ".join(f"t{i}" for i in range(6))):
        identify_states(
            GUESS, ["tendon.stiffness"], [replace(states, pulled=-np.abs(states.pulled))], [], HereExecutor()
        )


def test_a_tendon_that_no_row_tightens_is_named():
    """One is let out all the time; or the fit slackens all, because they bend the finger the wrong way."""
    states, pulled = states_of(rows=30), states_of(rows=30).pulled
    pulled[:, 2] = -20e-3
    found = identify_states(GUESS, ["tendon.stiffness"], [replace(states, pulled=pulled)], [], HereExecutor())
    assert state_doubts(found) == ["no row tightens t2: do they pull the other way?"]
    soft = robot(np.zeros(6), [0.0] * 6, [1e-7] * 6)
    assert slack_tendons(Model(soft), [states]) == [f"t{i}" for i in range(6)]
    assert slack_tendons(TRUE, [states]) == []
    nothing = unbalanced(states, np.arange(30))
    assert slack_tendons(TRUE, [nothing]) == []
