"""A camera that frames given points, and maps points of the world into its picture."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import ClippingRange, ColorRenderCamera, RenderCameraCore
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.viewpoint import nearest_eye, upright_view

ANGLE_OF_VIEW = np.radians(20.0)  # vertical
DIRECTION = np.array([0.2, 1.0, -0.22])  # of fingers alone: onto the x-z plane, a little from the left and above
MARGIN = 0.08  # of the picture, left free around what it shows
ASPECTS = (0.9, 2.0)  # narrowest and widest, where the width is left open


@dataclass(frozen=True)
class Camera:
    """A pinhole camera; its frame C has x to the right, y down and z into the picture."""

    X_WC: RigidTransform
    width: int  # pixels
    height: int

    def info(self, scale: int = 1) -> CameraInfo:
        """Drake's intrinsics of the same view with `scale` times as many pixels in a row."""
        return CameraInfo(scale * self.width, scale * self.height, ANGLE_OF_VIEW)

    def render_camera(self, renderer: str, scale: int) -> ColorRenderCamera:
        """The camera as a renderer takes it, `scale` times as large."""
        core = RenderCameraCore(renderer, self.info(scale), ClippingRange(0.05, 10.0), RigidTransform())
        return ColorRenderCamera(core)

    def project(self, p_W: Array) -> Array:
        """Where points of the world, (..., 3) m, lie in the picture, (..., 2) pixels right and down."""
        X_CW = self.X_WC.inverse()
        p_C = p_W @ X_CW.rotation().matrix().T + X_CW.translation()
        pixels: Array = (p_C / p_C[..., 2:] @ self.info().intrinsic_matrix().T)[..., :2]
        return pixels


def framing_camera(p_W: Array, height: int, width: int | None = None, direction: Array = DIRECTION) -> Camera:
    """The nearest upright camera that sees all points, (M, 3) m; without `width`, the picture is as wide as they are.

    It looks in `direction`, (3) in the world, of any length.
    """
    R_WC = upright_view(direction)
    if width is None:
        across, down, _ = np.ptp(p_W @ R_WC.matrix(), axis=0)
        width = round(height * np.clip(across / down, *ASPECTS))
    slope = np.tan(ANGLE_OF_VIEW / 2) * (1 - MARGIN) * np.array([width / height, 1.0])
    return Camera(RigidTransform(R_WC, nearest_eye(p_W, R_WC, -slope, slope)), width, height)
