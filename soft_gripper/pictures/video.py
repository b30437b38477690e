"""A recording as a film to keep: .mp4, or an animated picture."""

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

from PIL import Image

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.pictures.film import FRAME_RATE, Film
from soft_gripper.scenario.scenario import Scenario

ANIMATIONS = (".gif", ".webp", ".png")


def check_video(path: Path) -> None:
    """Says before any work is done whether a film of this name can be written.

    Raises:
        InputError: if the ending of the name is another, or what writes it is not installed.
    """
    if path.suffix == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            expected = "needs imageio-ffmpeg: pip install 'soft-gripper[video]'; or end it in .gif, .webp or .png"
            raise InputError("--video", "FILE", str(path), expected) from None
    elif path.suffix not in ANIMATIONS:
        raise InputError("--video", "FILE", str(path), f"end it in .mp4, {', '.join(ANIMATIONS)}")


def write_video(
    path: Path,
    scenario: Scenario,
    recording: Recording,
    progress: Callable[[float], None] | None = None,
    width: int = 640,
    height: int = 480,
) -> None:
    """Films a recording of a scenario at its own pace.

    Args:
        path: what to write; its ending says how.
        scenario: what was recorded.
        recording: of all that it did.
        progress: called with the simulated time, s, after every frame.
        width: of the scene, pixels, even.
        height: of the scene, pixels, even.

    Raises:
        InputError: if a film of this name cannot be written.
    """
    check_video(path)
    film = Film(scenario, recording, width, height)
    write = {".mp4": _write_mp4, ".gif": _write_gif}.get(path.suffix, _write_animation)
    with atomic_file(path) as partial:
        write(partial, film, _frames(film, progress))


def _frames(film: Film, progress: Callable[[float], None] | None) -> Iterator[Image.Image]:
    for time in film.times:
        yield film.frame(time)
        if progress is not None:
            progress(min(time + 1 / FRAME_RATE, film.duration))


def _write_animation(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    first, *others = frames
    first.save(path, save_all=True, append_images=others, duration=1000 / FRAME_RATE, loop=0)


def _write_gif(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    """One palette for all frames, from a few of them, keeps the colours from flickering."""
    samples = [film.frame(time) for time in film.times[:: max(1, len(film.times) // 4)]]
    width, height = film.size
    together = Image.new("RGB", (width, height * len(samples)))
    for i, sample in enumerate(samples):
        together.paste(sample, (0, height * i))
    palette = together.quantize(method=Image.Quantize.FASTOCTREE)
    _write_animation(path, film, (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames))


def _write_mp4(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    from imageio_ffmpeg import write_frames

    with closing(write_frames(str(path), film.size, fps=FRAME_RATE, quality=7, macro_block_size=2)) as writer:
        writer.send(None)
        for frame in frames:
            writer.send(frame.tobytes())
