"""Pictures of recordings: renderings, the shape of a finger, videos. None requires a display."""

from .phases import phases_figure as phases_figure
from .rendering import SceneRenderer as SceneRenderer
from .shape_figure import shape_figure as shape_figure
from .style import COLORS as COLORS
from .style import section_style as section_style
