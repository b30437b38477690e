"""The published experiments: what is fitted on which recordings, and what of them is kept for the test."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from soft_gripper.diagrams.hardware.find_recordings import find_recordings
from soft_gripper.diagrams.hardware.hardware_recording import HardwareRecording
from soft_gripper.diagrams.loading.model_files import model_path
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.evaluation.identify.finger_file import read_finger
from soft_gripper.evaluation.identify.identify import Identified, identify
from soft_gripper.evaluation.identify.measured_motion import measured_motion
from soft_gripper.evaluation.replay.arm_recording import arm_recording
from soft_gripper.evaluation.replay.replay_recordings import Replayed, Rows, estimator_rows, replay_recordings
from soft_gripper.evaluation.replay.replay_table import ReplayRow, replay_table


@dataclass(frozen=True)
class Experiment:
    """A finger fitted to recordings and tested on others; names are those of files without their suffix."""

    description: str  # shipped; the folder of the recordings is called so too, and so is the file of the finger
    free: tuple[str, ...]
    fitted: tuple[str, ...]
    tested: tuple[str, ...]

    @property
    def finger_file(self) -> Path:
        """Where the fit begins."""
        return model_path(f"package://soft_gripper/recordings/{self.description}.urdf")


BEAM = Experiment(
    "clamped_beam",
    ("youngs_modulus", "relaxation_time", "creep.share"),
    ("gravity", "load_52g"),
    ("load_101g",),
)
SEGMENT = Experiment(
    "pneumatic_segment",
    (
        "youngs_modulus",
        "relaxation_time",
        "pressure_law",
        "creep.share",
        "fill_time",
        "swelling",
        "mounting_x",
        "mounting_z",
    ),
    ("10kPa", "25kPa", "45kPa"),
    ("15kPa", "35kPa"),
)
ARM, TRIALS = "two_segment_arm", tuple(f"trial_{i}" for i in range(1, 6))
_SUFFIXES = {BEAM.description: ".csv", SEGMENT.description: ".csv", ARM: ".txt"}

Recordings = dict[str, HardwareRecording]
Report = Callable[[str, float], None]  # which experiment, and the root mean square that its fit has reached


@dataclass(frozen=True)
class Arm:
    """Every trial, estimated with what the others were fitted to."""

    replayed: list[Replayed]
    rows: Rows
    table: list[ReplayRow]


def published_recordings(data: Path | None) -> dict[str, Recordings]:
    """All recordings by description and name, read before anything is computed.

    Args:
        data: the folder with a folder for each description; None: the environment variable SOFT_GRIPPER_DATA.

    Raises:
        InputError: if the folder or one of the files is missing, or cannot be read.
    """
    if data is not None:
        require(data.is_dir(), "hardware", "--data", str(data), "there is no such folder")
    wanted = {of.description: of.fitted + of.tested for of in (BEAM, SEGMENT)} | {ARM: TRIALS}
    return {
        description: {name: _find(description, name, data) for name in names} for description, names in wanted.items()
    }


def identify_published(
    experiment: Experiment, recordings: Recordings, pool: ProcessPoolExecutor, report: Report
) -> Identified:
    """Fits a finger to the recordings of an experiment that are for that, and tests it on the others."""
    fitted, tested = (
        [measured_motion(recordings[name]) for name in names] for names in (experiment.fitted, experiment.tested)
    )
    finger = read_finger(experiment.finger_file)
    return identify(
        finger,
        experiment.free,
        fitted,
        tested,
        pool,
        report=lambda error: report(experiment.description, error),
    )


def replay_published(recordings: Sequence[HardwareRecording]) -> Arm:
    """Every trial of the arm by every estimator, fitted to the other trials."""
    arms, config, gravity = [arm_recording(one) for one in recordings], recordings[0].config, recordings[0].gravity
    assert config.finger is not None
    assert gravity is not None
    rows = estimator_rows(None, len(arms[0].bodies))
    replayed = replay_recordings(arms, None, rows, read_finger(model_path(config.finger)), gravity)
    return Arm(replayed, rows, replay_table(replayed, rows))


def _find(description: str, name: str, data: Path | None) -> HardwareRecording:
    file = f"{description}/{name}{_SUFFIXES[description]}"
    return find_recordings([file], description, data)[0]
