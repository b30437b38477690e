"""The colours of external torque: one scale for all pictures, on screen and on paper."""

from collections.abc import Iterable
from io import BytesIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording

MIN_LIMIT = 5e-3  # N m, of the scale; smaller torques are noise, and should not fill the bar
# Diverging from light grey, and safe for colour-blind readers: blue holds a finger open, red closes it.
COLORMAP = mpl.colormaps["coolwarm"].with_extremes(bad="0.35")


def color(torque: Array, limit: float) -> Array:
    """Colours of external torques (...) N m, as (..., 3) red, green, blue from 0 to 1.

    The scale runs from -`limit` to `limit` N m and keeps its end colours beyond; NaN, an unknown torque, is dark grey.
    """
    fraction = np.ma.masked_invalid(0.5 + 0.5 * np.asarray(torque, dtype=float) / limit)
    rgba: Array = np.asarray(COLORMAP(fraction))
    return rgba[..., :3]


def link_colors(torque: Array, limit: float) -> Array:
    """Colours of links, (N + 1, 3): by the torque at the proximal joint, (N) N m; the first is as the second."""
    return color(np.concatenate([torque[:1], torque]), limit)


def round_limit(torque: float) -> float:
    """A round limit for the scale: the smallest of 1, 2, 3 and 5 times a power of ten that covers `torque`, N m."""
    power = 10.0 ** np.floor(np.log10(torque))
    return float(next(power * step for step in (1, 2, 3, 5, 10) if torque <= power * step * (1 + 1e-9)))


def torque_limit(torques: Iterable[Array]) -> float:
    """The limit of a bar that covers all torques, N m; NaN (unknown) torques are ignored."""
    return max([MIN_LIMIT, *(float(np.nanmax(np.abs(torque), initial=0.0)) for torque in torques)])


def recorded_limit(*recordings: Recording) -> float:
    """The limit of a bar that covers the true external torques of all fingers in `recordings`, N m."""
    signals = [item for recording in recordings for item in recording.data.items()]
    return torque_limit(signal.values for name, signal in signals if str(name).endswith(".true_external_torque"))


def add_torque_bar(figure: Figure, limit: float, label: str = "external torque", **where: Any) -> Colorbar:
    """Draws the scale from -`limit` to `limit` N m, in mN m; `where` as for `Figure.colorbar`."""
    scale = ScalarMappable(Normalize(-1e3 * limit, 1e3 * limit), COLORMAP)
    bar = figure.colorbar(scale, **where)
    bar.set_label(f"opens  ←  {label} [mN m]  →  closes")
    bar.outline.set_visible(False)
    return bar


# Objects below the camera in Meshcat's tree move with it: x to the right, y up, z toward the viewer.
PATH = "/Cameras/default/rotated/<object>/legend"
_FIGURE_SIZE = (4.6, 0.8)  # inches of the figure
_BACKGROUND_COLOR = (1.0, 1.0, 1.0, 0.6)  # red, green, blue, opacity behind the scale
_CAMERA_DISTANCE = 0.05  # m from the camera, so close that nothing gets in between

# A rectangle with the picture on it. It is emissive: its colours match the scale in any light.
# With an opacity below 1, Meshcat respects the transparency of the picture.
_OBJ_TEXT = """mtllib legend.mtl
v -0.5 -0.5 0
v 0.5 -0.5 0
v 0.5 0.5 0
v -0.5 0.5 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
usemtl picture
f 1/1/1 2/2/1 3/3/1
f 1/1/1 3/3/1 4/4/1
"""
_MTL_TEXT = "newmtl picture\nKd 0 0 0\nKe 1 1 1\nd 0.999\nmap_Kd legend.png\nmap_Ke legend.png\n"


def draw_torque_legend(meshcat: Meshcat, limit: float, field_of_view: float) -> None:
    """Shows the scale from -`limit` to `limit` N m at the lower edge of the view, wherever the camera goes.

    Call this after the camera is set. `field_of_view` is the vertical angle of the camera, rad.
    """
    parts = {"legend.mtl": _MTL_TEXT.encode(), "legend.png": _picture(limit)}
    files = {name: MemoryFile(data, f".{name[-3:]}", name) for name, data in parts.items()}
    mesh = InMemoryMesh(mesh_file=MemoryFile(_OBJ_TEXT.encode(), ".obj", "legend.obj"), supporting_files=files)
    edge = _CAMERA_DISTANCE * np.tan(field_of_view / 2)
    height = 0.26 * edge
    meshcat.Delete(PATH)  # one attached to an earlier camera
    meshcat.SetObject(PATH, Mesh(mesh, scale3=[height * _FIGURE_SIZE[0] / _FIGURE_SIZE[1], height, 1.0]))
    meshcat.SetTransform(PATH, RigidTransform([0.0, 0.53 * height - edge, -_CAMERA_DISTANCE]))


def _picture(limit: float) -> bytes:
    buffer = BytesIO()
    with mpl.rc_context({"font.size": 9.3, "font.weight": "bold", "axes.labelweight": "bold"}):
        figure = Figure(figsize=_FIGURE_SIZE, dpi=200, facecolor=_BACKGROUND_COLOR)
        axes = figure.add_axes((0.06, 0.62, 0.88, 0.24))
        add_torque_bar(figure, limit, "estimated external torque", cax=axes, orientation="horizontal")
        figure.savefig(buffer, format="png")
    return buffer.getvalue()
