"""soft-gripper identify as a user calls it."""

import numpy as np
import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from identified import BEAM, RELEASED, finger_of, recorded, release, write_motion
from refusals import refusal

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.identification import settled_states as states_module
from soft_gripper.extras.hardware.identification.identified_finger import read_finger, read_setup
from soft_gripper.extras.hardware.identification.simulated_motion import Setup
from soft_gripper.extras.hardware.identification.tendon_balance import pulled_positions
from soft_gripper.fingers.spatial_chain import posture, spatial_chain

BESIDE = {f"fitted.{what}.yaml" for what in ("setup", "states", "confidence")}
WRITTEN = {"fitted.urdf", *BESIDE, "fitted.csv", "fitted.png", "fitted.svg"}


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Recordings of a beam, its first guess, and a folder in which nothing is written yet."""
    monkeypatch.chdir(tmp_path)
    truth = finger_of(BEAM, tmp_path)
    (tmp_path / "recording.yaml").write_text(RELEASED)
    for seed, name in enumerate(("run", "again")):
        motion = recorded(truth, release(0.8), seed=seed)
        write_motion(tmp_path / f"{name}.csv", motion.time, motion.markers)
    guess = BEAM.replace('material="dragon_skin_10"', 'youngs_modulus="2.75e5" density="1070"')
    (tmp_path / "guess.urdf").write_text(guess)
    (tmp_path / "out").mkdir()
    return tmp_path


def command(*arguments, free=("youngs_modulus",), jobs=1, out="out/fitted.urdf", finger="guess.urdf"):
    return "identify", *arguments, "--finger", finger, "--free", *free, "--out", out, "--jobs", jobs


def identify(*arguments, **options):
    return soft_gripper(*command(*arguments, **options))


@pytest.mark.slow
def test_same_files_from_one_process_and_from_two(files):
    written = []
    for jobs in (1, 2):
        outcome = identify("run.csv", "--test", "again.csv", jobs=jobs)
        assert outcome.code == 0, outcome.err
        written.append({name: (files / "out" / name).read_bytes() for name in ("fitted.urdf", "fitted.csv")})
    assert written[0] == written[1]
    assert {path.name for path in (files / "out").iterdir()} == WRITTEN
    assert read_finger(files / "out/fitted.urdf").base.youngs_modulus == pytest.approx(2.64e5, rel=0.01)
    roles = [(row["recording"], row["role"]) for row in csv_rows(files / "out/fitted.csv")]
    assert roles == [("run", "fit"), ("again", "test")]
    assert "youngs_modulus" in outcome.out
    assert "out/fitted.urdf" in outcome.out


@pytest.mark.slow
def test_a_fitted_finger_is_tested_without_a_fit(files):
    """With the set-up beside it, and the held pose that this asks for; and the finger is not written again."""
    (files / "true.urdf").write_text(BEAM)
    (files / "true.setup.yaml").write_text("held_pose: true\nmarker_mass: 0.0\nheaviest_load: 0.01\n")
    arguments = "--test", "run.csv", "--finger", "true.urdf", "--jobs", 1
    outcome = soft_gripper("identify", *arguments, "--out", "out/tested.urdf")
    assert outcome.code == 0, outcome.err
    assert {path.name for path in (files / "out").iterdir()} == {"tested.csv", "tested.png", "tested.svg"}
    row, unheld = csv_rows(files / "out/tested.csv")
    assert (row["recording"], row["role"], unheld["role"]) == ("run", "test", "test, hold unknown")
    assert float(row["motion_error_mm"]) < 0.05
    assert "run: held" in outcome.out
    assert "youngs_modulus" not in outcome.out


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "give recordings to fit to, or --test ones"),
        (("run.csv", "--out", "out/a.urdf"), "--free"),
        (("run.csv", "--free", "length"), "--out"),
        (("--test", "run.csv", "--free", "length"), "nothing is fitted"),
    ],
)
def test_options_of_a_fit_need_one(arguments, said):
    assert said in refusal("identify", *arguments, "--finger", "guess.urdf")


@pytest.mark.slow
def test_says_what_cannot_be_told_apart(files):
    outcome = identify("run.csv", free=("youngs_modulus", "density"))
    assert outcome.code == 0, outcome.err
    (said,) = [line for line in outcome.out.splitlines() if line.startswith("dropped")]
    density = read_finger(files / "out/fitted.urdf").base.density
    assert said.startswith("dropped density, which is not determined beside youngs_modulus (correlation +")
    assert said.endswith(f"; kept at {density:.5g} kg/m^3")
    head = (files / "out/fitted.setup.yaml").read_text().splitlines()[:3]
    assert head[1:] == ["# Fitted: youngs_modulus", f"# {said}"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"free": ["stiffness"]}, "there is no such key; known: youngs_modulus"),
        ({"finger": "two.urdf"}, "give a file with one finger"),
    ],
)
def test_mistakes_are_named(files, changes, said):
    begin, end = BEAM.index("<finger"), BEAM.index("</finger>") + len("</finger>")
    (files / "two.urdf").write_text(BEAM[:end] + BEAM[begin:end].replace('"beam"', '"other"') + BEAM[end:])
    assert said in refusal(*command("run.csv", **changes))


SETTLED = """
event: settled
length: 0.1
tendons: {columns: {pull: pull_mm}, unit: mm}
markers: {unit: mm, bodies: {tip: [tip]}, places: {tip: [0, 0, 0.008]}}
labels: {column: what, family: "in|out"}
frame: {origin: [0, 0, 0]}
"""
TENDON = '<tendon name="pull" x="0.01" y="0" at="0 1" stiffness="{}" slack="{}"/>'


@pytest.fixture
def settled(files):
    """A finger that a tendon closes, at rest, pulled in and let out; and its first guess."""
    of_tendon = BEAM.replace('<creep share="0.2" time="0.2"/>', TENDON)
    truth = finger_of(of_tendon.format(5e4, 1e-3), files)
    pulled = np.concatenate([np.linspace(0, 8e-3, 12), np.linspace(8e-3, 0, 12)])
    bend = pulled_positions(truth, pulled[:, None])
    chain = posture(spatial_chain(truth), bend)
    tip = chain.origins[:, -1] + (truth.segment_length / 2 + 8e-3) * chain.rotations[:, -1, :, 2]
    rows = [
        f"{i},{'in' if i < 12 else 'out'}_{i},{1e3 * length!r},{','.join(map(repr, (1e3 * place).tolist()))}"
        for i, (length, place) in enumerate(zip(pulled.tolist(), tip, strict=True))
    ]
    (files / "rest.csv").write_text("\n".join(["time,what,pull_mm,tip_x,tip_y,tip_z", *rows]) + "\n")
    (files / "rest.yaml").write_text(SETTLED)
    (files / "guess.urdf").write_text(of_tendon.format(4e4, 0))
    return files


@pytest.mark.slow
def test_settled_states_of_a_tendon(settled):
    """Slack and stiffness are found, written to the file, and each family is predicted from the other."""
    outcome = identify("rest.csv", "--test", "rest.csv", free=("tendon.slack", "tendon.stiffness"))
    assert outcome.code == 0, outcome.err
    (tendon,) = read_finger(settled / "out/fitted.urdf").tendons
    assert (tendon.slack, tendon.stiffness) == pytest.approx((1e-3, 5e4), rel=1e-3)
    assert {path.name for path in (settled / "out").iterdir()} == WRITTEN
    table = csv_rows(settled / "out/fitted.csv")
    rows = {(row["role"], row["family"]): float(row["rms_mm"]) for row in table}
    assert set(rows) == {("fit", "all"), ("test", "all"), *(("left out", name) for name in ("all", "in", "out"))}
    assert max(rows.values()) < 1e-2
    assert "left out" in outcome.out


def test_what_was_found_survives_the_end_of_the_command(settled, monkeypatch):
    """A fit that fails after its last step has left the finger so far, and a line for every step; both files whole."""

    def fails(*_):
        raise InputError("identify", "left out", 0, "fails")

    monkeypatch.setattr(states_module, "_family_errors", fails)
    outcome = identify("rest.csv", free=("tendon.slack", "tendon.stiffness"))
    assert outcome.code == 2
    assert {path.name for path in (settled / "out").iterdir()} == {"fitted.urdf", "fitted.setup.yaml"}
    (tendon,) = read_finger(settled / "out/fitted.urdf").tendons
    assert (tendon.slack, tendon.stiffness) == pytest.approx((1e-3, 5e4), rel=1e-2)
    assert read_setup(settled / "out/fitted.urdf") == Setup()
    steps = [line for line in outcome.err.splitlines() if line.startswith("fitting: step ")]
    errors = [float(line.split("marker error ")[1].split(" %")[0]) for line in steps]
    assert len(errors) > 2
    assert errors[-1] < 0.1 * errors[0]
    assert "# Not final: the search had come to step" in (settled / "out/fitted.setup.yaml").read_text()
