"""Which recordings the published experiments take."""

import pytest
from hardware_files import published

from soft_gripper.errors import InputError
from soft_gripper.evaluation.hardware.experiments import BEAM, SEGMENT, published_recordings
from soft_gripper.evaluation.identify.finger_file import read_finger
from soft_gripper.evaluation.identify.free_parameters import free_parameters


@pytest.mark.parametrize("experiment", [BEAM, SEGMENT])
def test_nothing_is_fitted_and_tested(experiment):
    assert not set(experiment.fitted) & set(experiment.tested)


@pytest.mark.parametrize("experiment", [BEAM, SEGMENT])
def test_the_finger_files_have_what_is_freed(experiment):
    free = free_parameters(read_finger(experiment.finger_file), experiment.free, [1e4])
    assert set(free.keys) == set(experiment.free)


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(InputError, match="there is no such folder") as refused:
        published_recordings(tmp_path / "nowhere")
    assert "\n" not in str(refused.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"clamped_beam/gravity\.csv") as refused:
        published_recordings(tmp_path)
    assert "\n" not in str(refused.value)


def test_reads_all_published_recordings():
    found = published_recordings(published("clamped_beam").parent)
    assert {name: len(recordings) for name, recordings in found.items()} == {
        "clamped_beam": 3,
        "pneumatic_segment": 5,
        "two_segment_arm": 5,
    }
