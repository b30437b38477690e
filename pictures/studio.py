"""How a scene is lit when its picture is taken."""

from pydrake.geometry import LightParameter, MakeRenderEngineVtk, RenderEngine, RenderEngineVtkParams, SsaoParameter

# Position in the world, m, and intensity. Lamps at a point cast no shadow maps, which are speckled in VTK.
LAMPS = (
    ((0.0, -1.0, 6.0), 0.8),
    ((-2.0, -6.0, 1.5), 0.6),
    ((6.0, -2.0, 0.5), 0.38),
    ((-6.0, -2.0, 0.5), 0.42),
    ((0.0, -1.0, -6.0), 0.3),
)


def make_studio() -> RenderEngine:
    """A renderer with lamps all round, a white background, and soft shading where things meet."""
    lamps = [
        LightParameter(type="point", frame="world", position=position, intensity=intensity)
        for position, intensity in LAMPS
    ]
    shading = SsaoParameter(radius=0.03, bias=0.01, sample_count=16, blur=True)
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=[1.0, 1.0, 1.0], lights=lamps, ssao=shading))
