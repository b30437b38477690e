"""Films of recordings: so many frames, of the right things, in a whole file or none."""

from pathlib import Path

import numpy as np
import pytest
from command_line import short, soft_gripper
from finger_plants import free_bending
from PIL import Image, ImageSequence

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.pictures.video import FOOTER, Film, write_video
from soft_gripper.scenario.schema import Scenario

pytestmark = pytest.mark.slow

FRAMES = 6  # ten a second
SIZE = (200, 100)
Run = tuple[Scenario, Recording]


@pytest.fixture(scope="module")
def run() -> Run:
    """Two fingers close for 0.6 s."""
    scenario = free_bending([60e3, 120e3], 0.3)
    return scenario, simulate(scenario)


@pytest.fixture(scope="module")
def expected(run: Run) -> np.ndarray:
    """The frames, (FRAMES, height, width, 3)."""
    film = Film(*run, *SIZE)
    return np.array([film.frame(time) for time in np.arange(FRAMES) / 10]).astype(int)


@pytest.mark.parametrize("ending", [".gif", ".webp", ".png"])
def test_an_animated_picture_shows_the_recording_at_its_own_pace(
    run: Run, expected: np.ndarray, tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"film{ending}"
    reported: list[float] = []
    write_video(path, *run, reported.append, *SIZE)
    with Image.open(path) as picture:
        shown = [(np.array(frame.convert("RGB")), frame.info["duration"]) for frame in ImageSequence.Iterator(picture)]
    assert [duration for _, duration in shown] == [100] * FRAMES
    for i, (frame, _) in enumerate(shown):
        distances = np.abs(frame - expected).mean(axis=(1, 2, 3))
        assert np.argmin(distances) == i
        assert distances[i] < 3
    np.testing.assert_allclose(reported, np.arange(1, FRAMES + 1) / 10)


def test_the_scene_moves_and_the_footer_shows_time_and_torques(expected: np.ndarray) -> None:
    first, last = expected[0], expected[-1]
    footer, scale = slice(SIZE[1], None), slice(SIZE[0] // 2, None)
    assert np.abs(first - last)[: SIZE[1]].max() > 100
    assert np.abs(first - last)[footer, : SIZE[0] // 2].max() > 100
    np.testing.assert_array_equal(first[footer, scale], last[footer, scale])
    red, _, blue = np.moveaxis(first[footer, scale], -1, 0)
    assert (red - blue).max() > 100
    assert (blue - red).max() > 100


@pytest.mark.parametrize("ending", [".gif", ".webp", ".mp4"])
def test_a_film_that_fails_leaves_no_file(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")

    def frame(self: Film, time: float) -> Image.Image:
        if time > 0.2:
            raise RuntimeError("no more")
        return Image.new("RGB", self.size, (int(1000 * time), 0, 0))

    monkeypatch.setattr(Film, "frame", frame)
    with pytest.raises(RuntimeError, match="no more"):
        write_video(tmp_path / f"film{ending}", *run, None, *SIZE)
    assert not list(tmp_path.iterdir())


def test_run_writes_a_film(tmp_path: Path) -> None:
    film = tmp_path / "films" / "peg.gif"
    options = short("pressure.steps.all=[50e3]", "pressure.settle=0.1", "pressure.hold_samples=5")
    outcome = soft_gripper("run", "obstructed_inside", *options, "--out", tmp_path, "--video", film)
    assert outcome.code == 0
    with Image.open(film) as picture:
        assert (picture.n_frames, picture.size) == (2, (640, 480 + FOOTER))
