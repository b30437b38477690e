"""A recording as a video: .mp4, or an animated picture."""

from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageDraw, ImageFont

from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, recorded_limit
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.pictures.phases import CloseUp
from soft_gripper.pictures.rendering import Picture, SceneRenderer
from soft_gripper.pictures.shape_figure import leaves_plane
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.poses import TRUE_JOINTS

FRAME_RATE = 10  # frames per second of simulated time
FOOTER = 60  # pixels, below the scene
_INSET_WIDTH = 0.4  # share of the width, of a close-up or a view from the side
_LIGHT_IN_SPACE = 0.85  # of a finger that turns toward the lamps, and would be white on white
_PLOT_GAP = 4  # pixels, between it and the scene
_DRIVE_UNITS = {"pressure": (1e-3, "kPa"), "tension": (1.0, "N")}  # of what drives fingers
_FRAMED_TIMES = 20  # number of times in a recording that the close-up must cover
ANIMATIONS = (".gif", ".webp", ".png")


class Film:
    """The frames of a video of a recording in real time; the scene is `width` x `height` pixels.

    A gripper on an arm is small in the scene, so a close-up next to it takes part of the width; so does a view from
    the right of fingers without an arm that leave their planes.
    """

    def __init__(self, scenario: Scenario, recording: Recording, width: int, height: int):
        self.duration = float(recording.data["time"][-1])  # s
        self.times = np.arange(max(1, round(self.duration * FRAME_RATE))) / FRAME_RATE  # s, of the frames
        self.size = (width, height + FOOTER)  # pixels
        self._scenario, self._recording = scenario, recording
        joints = (signal.values for name, signal in recording.data.items() if str(name).endswith(f".{TRUE_JOINTS}"))
        limit, leaves_planes = recorded_limit(recording), any(map(leaves_plane, joints))
        light = _LIGHT_IN_SPACE if leaves_planes else 1.0
        render = partial(SceneRenderer, scenario, recording, height, torque_limit=limit, light=light)
        inset_width = round(_INSET_WIDTH * width) if scenario.arm is not None or leaves_planes else 0
        self._renderer = render(width=width - inset_width)
        self._render_beside: Callable[[float], Picture] | None = None
        if scenario.arm is not None:
            times = np.linspace(0, self.duration, _FRAMED_TIMES)
            close_up = CloseUp(self._renderer, times, height, inset_width - _PLOT_GAP)
            self._render_beside = lambda time: self._renderer.render(time, close_up.camera(time))
        elif leaves_planes:
            self._render_beside = render(width=inset_width - _PLOT_GAP, aside=True).render
        self._scale = _draw_scale(limit, width // 2)

    def frame(self, time: float) -> Image.Image:
        width, height = self.size
        frame = Image.new("RGB", self.size, "white")
        frame.paste(Image.fromarray(self._renderer.render(time)), (0, 0))
        if self._render_beside is not None:
            frame.paste(Image.fromarray(self._render_beside(time)), (self._renderer.camera.width + _PLOT_GAP, 0))
        frame.paste(self._scale, (width - self._scale.width, height - FOOTER))
        font = ImageFont.load_default(0.025 * width)
        place = (0.03 * width, height - FOOTER / 2)
        ImageDraw.Draw(frame).text(place, self._caption(time), "black", font, anchor="lm")
        return frame

    def _caption(self, time: float) -> str:
        """The time, the pressures and tensions of the fingers, and the state of the task; equal ones are given once."""
        data = self._recording.data.sel(time=time, method="nearest")
        pressures = [
            f"{'/'.join(f'{scale * value:.0f}' for value in signal.values.flat)} {unit}"
            for kind, (scale, unit) in _DRIVE_UNITS.items()
            for name, signal in data.data_vars.items()
            if str(name).endswith(f".{kind}")
        ]
        texts = [f"{time:4.1f} s", ", ".join(dict.fromkeys(pressures))]
        if self._scenario.task is not None:  # its phase, or its outcome after the last phase or a failure
            phases, i = self._scenario.task.phases, int(data["task.phase"])
            texts.append(phases[i].name if i < len(phases) else Outcome(int(data["task.outcome"])).words)
        return "     ".join(texts)


def _draw_scale(limit: float, width: int) -> Image.Image:
    """The colour scale, which ends at `limit` N m, as high as the footer."""
    figure = Figure(figsize=(width / 100, FOOTER / 100), dpi=100)
    axes = figure.add_axes((0.05, 0.72, 0.87, 0.18))
    bar = add_torque_bar(figure, limit, cax=axes, orientation="horizontal")
    bar.ax.tick_params(labelsize=7, length=2, pad=1)
    bar.ax.xaxis.label.set_fontsize(8)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return Image.open(picture)


def check_video(path: Path) -> None:
    """Raises an InputError if a video with this name cannot be written, before any work is done."""
    if path.suffix == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            expected = "requires imageio-ffmpeg: pip install 'soft-gripper[video]'; or name a .gif, .webp or .png file"
            raise InputError("--video", "FILE", str(path), expected) from None
    elif path.suffix not in ANIMATIONS:
        raise InputError("--video", "FILE", str(path), f"give a name that ends in .mp4, {', '.join(ANIMATIONS)}")


def write_video(
    path: Path,
    scenario: Scenario,
    recording: Recording,
    progress: Callable[[float], None] | None = None,
    width: int = 640,
    height: int = 480,
) -> None:
    """Writes a video of a recording of a scenario, in real time; raises as `check_video`.

    The ending of the path selects the format; `progress` is called with the simulated time, s, after each frame. Width
    and height are those of the scene, pixels, and even.
    """
    check_video(path)
    film = Film(scenario, recording, width, height)

    def frames() -> Iterator[Image.Image]:
        for time in film.times:
            yield film.frame(time)
            if progress is not None:
                progress(min(time + 1 / FRAME_RATE, film.duration))

    write = {".mp4": _write_mp4, ".gif": _write_gif}.get(path.suffix, _write_animation)
    with atomic_file(path) as partial:
        write(partial, film, frames())


def _write_animation(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    first, *later_frames = frames
    first.save(path, save_all=True, append_images=later_frames, duration=1000 / FRAME_RATE, loop=0)


def _write_gif(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    """Uses one palette for all frames, computed from a few of them, so that the colours do not flicker."""
    samples = [film.frame(time) for time in film.times[:: max(1, len(film.times) // 4)]]
    width, height = film.size
    image = Image.new("RGB", (width, height * len(samples)))
    for i, sample in enumerate(samples):
        image.paste(sample, (0, height * i))
    palette = image.quantize(method=Image.Quantize.FASTOCTREE)
    _write_animation(path, film, (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames))


def _write_mp4(path: Path, film: Film, frames: Iterator[Image.Image]) -> None:
    from imageio_ffmpeg import write_frames

    with closing(write_frames(str(path), film.size, fps=FRAME_RATE, quality=7, macro_block_size=2)) as writer:
        writer.send(None)
        for frame in frames:
            writer.send(frame.tobytes())
