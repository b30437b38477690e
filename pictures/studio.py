"""How a scene is lit when its picture is taken."""

import numpy as np
from pydrake.geometry import LightParameter, MakeRenderEngineVtk, RenderEngine, RenderEngineVtkParams, SsaoParameter
from pydrake.math import RotationMatrix

from soft_gripper.arrays import Array

# Position before a viewer who looks along +y, m, and intensity. Lamps at a point cast no shadows.
LAMPS = (
    ((0.0, -1.0, 6.0), 0.8),
    ((-2.0, -6.0, 1.5), 0.6),
    ((6.0, -2.0, 0.5), 0.38),
    ((-6.0, -2.0, 0.5), 0.42),
    ((0.0, -1.0, -6.0), 0.3),
)
DIMMED = 0.9  # what is left of that beside the sun
SUN = np.array([-0.22, -0.40, 0.89])  # direction in which it stands, of length 1
SUN_INTENSITY = 0.25
SUN_DISTANCE = 8.0  # in radii of what it shines on
_CONE = 12.0  # degrees from the middle of its light to the edge
_WHITE = [1.0, 1.0, 1.0]


def make_studio() -> RenderEngine:
    """A renderer for fingers alone: lamps all round, a white background, and soft shading where things meet."""
    shading = SsaoParameter(radius=0.03, bias=0.01, sample_count=16, blur=True)
    lamps = [_lamp(np.array(position), intensity) for position, intensity in LAMPS]
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE, lights=lamps, ssao=shading))


def make_workshop(direction: Array, p_W: Array) -> RenderEngine:
    """A renderer for an arm: lamps round one who looks in `direction`, and a sun, whose shadows show heights.

    The sun shines on what lies between the points p_W, (M, 3) m, and round about.
    """
    turn = RotationMatrix.MakeZRotation(np.arctan2(-direction[0], direction[1]))
    lamps = [_lamp(turn @ np.array(position), DIMMED * intensity) for position, intensity in LAMPS]
    radius, toward_sun = np.linalg.norm(np.ptp(p_W, axis=0)) / 2, turn @ SUN
    sun = LightParameter(
        type="spot",
        frame="world",
        position=(p_W.min(axis=0) + p_W.max(axis=0)) / 2 + SUN_DISTANCE * radius * toward_sun,
        direction=-toward_sun,
        cone_angle=_CONE,
        intensity=SUN_INTENSITY,
    )
    lights, shadows = [*lamps, sun], {"cast_shadows": True, "shadow_map_size": 2048}
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE, lights=lights, **shadows))


def _lamp(position: Array, intensity: float) -> LightParameter:
    return LightParameter(type="point", frame="world", position=position, intensity=intensity)
