"""Reads points and analog channels of C3D files (https://www.c3d.org) with ezc3d, in a separate process."""

from pathlib import Path
from typing import Any


def c3d_points(path: Path) -> dict[str, Any]:
    """Points (3, markers, frames), analog channels (channels, samples), and attributes of both."""
    import ezc3d

    file = ezc3d.c3d(str(path))
    points, analogs = file["data"]["points"][:3], file["data"]["analogs"][0]
    attributes = {name: file["parameters"]["POINT"][name]["value"] for name in ("RATE", "LABELS", "UNITS")}
    channels = file["parameters"]["ANALOG"].get("LABELS", {"value": []})["value"]
    return {**attributes, "points": points, "analogs": analogs, "CHANNELS": channels}
