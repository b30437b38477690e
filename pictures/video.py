"""A film of a recording, with the time, the pressures and the scale of the torques below the scene."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.torque_colors import add_torque_bar
from soft_gripper.pictures.rendering import Picture, SceneRenderer
from soft_gripper.pictures.torque_scale import recorded_limit

from soft_gripper.errors import InputError
from soft_gripper.files import whole_file

FRAME_RATE = 10  # frames a second of simulated time
PILLOW = (".gif", ".webp", ".png")


def check_video(path: Path) -> None:
    """Says before any work is done whether a film of this name can be written.

    Raises:
        InputError: if the ending of the name is another, or what writes it is not installed.
    """
    if path.suffix not in (".mp4", *PILLOW):
        raise InputError("--video", "FILE", str(path), f"end it in .mp4, {', '.join(PILLOW)}")
    if path.suffix == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            expected = f"needs imageio-ffmpeg: pip install 'soft-gripper[video]'; or end it in {', '.join(PILLOW)}"
            raise InputError("--video", "FILE", str(path), expected) from None


def write_video(
    path: Path,
    scenario: Scenario,
    recording: Recording,
    progress: Callable[[float], None] = lambda time: None,
    width: int = 640,
    height: int = 480,
) -> None:
    """Films a recording from its beginning to its end, `FRAME_RATE` frames a second of simulated time.

    Args:
        path: what to write; its ending says how.
        scenario: what was recorded.
        recording: of that scenario.
        progress: called with the simulated time of every frame, s.
        width: of the scene, pixels, even.
        height: of the scene, pixels, even.
    """
    check_video(path)
    with whole_file(path) as partial:
        frames = film(scenario, recording, progress, width, height)
        if path.suffix == ".mp4":
            _write_mp4(partial, frames)
        else:
            _write_animation(partial, frames)
