"""Folders as the benchmark takes them."""

from pathlib import Path

from scale_files import write_log

FORCES = "measured_force/scale"


def write_force_folder(data: Path) -> Path:
    """A folder with logs of a finger on a scale: one place is trained on, another is tested."""
    folder = data / FORCES
    folder.mkdir(parents=True)
    log = write_log(folder)
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    half = len(lines) // 2
    (folder / "train.csv").write_text("".join(lines[:half]), encoding="utf-8")
    (folder / "test.csv").write_text("".join(lines[half:]), encoding="utf-8")
    (folder / "one.yaml").rename(folder / "finger.yaml")
    for other in (log, folder / "scale.yaml"):
        other.unlink()
    return folder
