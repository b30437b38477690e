"""Single contacts of a finger at rest, with ground truth: as arrays, and in a file.

In: a finger and arrays, or a file of them. Out: `Contacts`. Another quantity is a field of `Contacts` and an entry of
_ARRAYS.
"""

import math
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import posture, spatial_chain, vector_product
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import model_path
from soft_gripper.sensors.measurement import spatial_deformations

FINGER = "package://soft_gripper/grippers/finger.urdf"
G = 9.81  # m/s^2
INNER, OUTER = 0.0, math.pi  # sides
MAX_FRICTION = 100.0  # Coulomb; with more, nothing slides


@cache
def read_finger() -> Finger:
    """Reads the shipped finger, which has all contacts here."""
    (finger,) = expand_urdf(model_path(FINGER)).fingers
    return finger


@dataclass(frozen=True, eq=False)
class Contacts:
    """Ground truth of M contacts of one finger at rest, whose D joint positions are flat, by deformation."""

    finger: Finger
    q: Array  # (M, D) rad
    pressure: Array  # (M,) Pa
    gravity: Array  # (M, 3) m/s^2 in B
    normal_force: Array  # (M,) N, along the normal of the face
    force: Array  # (M, 3) N in B, friction included
    torque: Array  # (M, D) N m, of the contact at the joints
    arc_length: Array  # (M,) m, from the base
    side: Array  # (M,) rad around the finger: 0 on the inner side, pi / 2 toward +y
    friction: Array  # (M,) Coulomb

    def subset(self, rows: NDArray[np.int_] | NDArray[np.bool_]) -> "Contacts":
        """Some of the contacts."""
        return Contacts(self.finger, *(getattr(self, name)[rows] for name in _ARRAYS))

    @property
    def is_inside(self) -> NDArray[np.bool_]:
        """Contacts that press on the inner side, (M,)."""
        return np.cos(self.side) > 0

    @cached_property
    def transverse_force(self) -> Array:
        """Size of the part of the force at right angles to the line from the base to the contact on the axis, (M,) N.

        By its moment about the base, over the distance of that place.
        """
        finger, chain = self.finger, spatial_chain(self.finger)
        q = self.q[:, chain.position_indices(spatial_deformations(finger))]
        link = np.searchsorted(finger.joint_arc_lengths, self.arc_length)
        frames = posture(chain, q).frames[np.arange(len(link)), chain.link_frames(link)]
        height = self.arc_length - finger.link_ends[:-1][link]
        point = frames[:, :3, 3] + height[:, None] * frames[:, :3, 2]
        moment = vector_product(point, self.force)
        return np.asarray(np.linalg.norm(moment, axis=-1) / np.linalg.norm(point, axis=-1))


_ARRAYS: dict[str, tuple[str, float, float, str]] = {  # unit, range and last axis
    "q": ("rad", -math.pi, math.pi, "joint"),
    "pressure": ("Pa", -1e6, 1e6, ""),
    "gravity": ("m/s^2", -100, 100, "xyz"),
    "normal_force": ("N", 1e-3, 1e3, ""),  # errors are fractions of it
    "force": ("N", -1e3, 1e3, "xyz"),
    "torque": ("N m", -100, 100, "joint"),
    "arc_length": ("m", 0, 1, ""),
    "side": ("rad", -math.pi, math.pi, ""),
    "friction": ("1", 0, MAX_FRICTION, ""),
}


def save_contacts(contacts: Contacts, path: Path) -> None:
    """Writes a netCDF file with an array for every field."""
    arrays = {
        name: (("contact", axis) if axis else ("contact",), getattr(contacts, name), {"units": unit})
        for name, (unit, _, _, axis) in _ARRAYS.items()
    }
    Recording(xr.Dataset(arrays)).save(path)


def load_contacts(path: Path | str) -> Contacts:
    """Reads contacts of the shipped finger, which `save_contacts` wrote.

    Raises:
        InputError: naming the array, if one is missing, damaged, or has values that are impossible for this finger.
    """
    data, finger = Recording.load(path).data, read_finger()
    sizes = {"": (), "xyz": (3,), "joint": (finger.segments,)}
    return Contacts(finger, *(_read_array(path, data, name, sizes[kind[-1]]) for name, kind in _ARRAYS.items()))


def _read_array(path: Path | str, data: xr.Dataset, name: str, axes: tuple[int, ...]) -> Array:
    if name not in data:
        raise InputError(path, "array", name, "is not in the file; python -m studies contacts writes it")
    values, (_, low, high, _) = data[name].values, _ARRAYS[name]
    expected = (data.sizes.get("contact", 0), *axes)
    if values.dtype != float or values.shape != expected or not expected[0]:
        dtype = f"{values.dtype} {values.shape}"
        raise InputError(path, name, dtype, f"give numbers of shape {('contacts', *axes)}, with at least one contact")
    wrong_values = values[~((low <= values) & (values <= high))]
    if len(wrong_values):
        raise InputError(path, name, float(wrong_values[0]), f"give numbers of {low:.3g} to {high:.3g}")
    return np.asarray(values)
