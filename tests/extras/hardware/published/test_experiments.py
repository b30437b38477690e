"""Which recordings the published experiments take."""

import pytest
from hardware_files import published
from refusals import refused
from synthetic_hardware import write_beam

from soft_gripper.extras.hardware import published as experiments
from soft_gripper.extras.hardware.identification.free_parameters import free_parameters
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.published import BEAM, SEGMENT, identify_published, published_recordings
from soft_gripper.runs.executor import open_executor


@pytest.mark.parametrize("experiment", [BEAM, SEGMENT])
def test_nothing_is_fitted_and_tested(experiment):
    assert not set(experiment.fitted) & set(experiment.tested)


@pytest.mark.parametrize("experiment", [BEAM, SEGMENT])
def test_the_finger_files_have_what_is_freed(experiment):
    free = free_parameters(read_finger(experiment.finger_file), experiment.free, [1e4])
    assert {name.split("pressure_law.")[0] or "pressure_law" for name in free.keys} == {*experiment.free} - {
        "held_pose"
    }


def test_a_missing_folder_is_named(tmp_path):
    with refused("--data", str(tmp_path / "nowhere")):
        published_recordings(tmp_path / "nowhere")


def test_a_missing_file_is_named(tmp_path):
    with refused("FILE", "clamped_beam/gravity.csv"):
        published_recordings(tmp_path)


def test_reads_all_published_recordings():
    found = published_recordings(published("clamped_beam").parent)
    assert {name: len(recordings) for name, recordings in found.items()} == {
        "clamped_beam": 3,
        "pneumatic_segment": 7,
        "two_segment_arm": 6,
    }


def test_what_is_fitted_and_what_tests_go_where_they_belong(tmp_path, monkeypatch):
    """And each recording is the one of its name: weights and pressures of their own."""
    write_beam(tmp_path / "clamped_beam", 0.9)
    recordings = {name: experiments._find("clamped_beam", name, tmp_path) for name in BEAM.fitted + BEAM.tested}
    called = []
    monkeypatch.setattr(experiments, "identify", lambda *given, **_: called.append(given))
    identify_published(BEAM, recordings, None, print)
    ((finger, free, fitted, tested, _),) = called
    assert [motion.name for motion in fitted] == ["gravity", "load_52g"]
    assert [motion.name for motion in tested] == ["load_101g"]
    assert [motion.load and motion.load.mass for motion in (*fitted, *tested)] == [None, pytest.approx(0.052), 0.102]
    assert free == BEAM.free
    assert finger == read_finger(BEAM.finger_file)


@pytest.mark.published
def test_the_segment_is_fitted_as_well_as_the_documentation_says():
    """By the documented fit: bend, speed and creep at pressures that were not fitted hold, but one time is too short.

    Creep is as far off where it is seen without pressure; that is a miss, too.
    """
    data, errors = published("pneumatic_segment").parent, []
    recordings = {name: experiments._find("pneumatic_segment", name, data) for name in SEGMENT.fitted + SEGMENT.tested}
    with open_executor(None, None) as executor:
        found = identify_published(SEGMENT, recordings, executor, lambda step: errors.append(step.error))
    assert 4.2 < 100 * errors[-1] < 5
    assert [dropped.name for dropped in found.confidence.undetermined] == ["swelling"]
    rows = {row.recording: row for row in found.scores if row.role == "test"}
    assert set(rows) == set(SEGMENT.tested)
    for name, row in rows.items():
        assert row.simulated_settled_turn_deg == pytest.approx(row.settled_turn_deg, rel=0.08), name
        assert row.simulated_creep_deg == pytest.approx(row.creep_deg, rel=0.35), name
        assert row.simulated_t50_ms == pytest.approx(row.t50_ms, rel=0.22), name
        assert row.tip_error_percent < 5, name
        is_late = abs(row.simulated_t63_ms / row.t63_ms - 1) > 0.2
        assert is_late == (name == "35kPa"), name
