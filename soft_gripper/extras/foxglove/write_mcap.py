"""Writes recordings as MCAP files (https://mcap.dev) with a layout, for Foxglove (https://docs.foxglove.dev).

Every signal of up to 100 numbers is a topic, `/left_finger/strain`, whose messages are {timestamp, value} in JSON. An
axis with names is an object, one with numbers is a list: `/left_finger/strain.value.inner[0]`; unknown
values are null. Covariances are left out: they would be most of the file. Fingers, contacts and objects are drawn by
topics with schemas of Foxglove, in m in the frame `world`; there is no message while the value is unknown. Another such
topic is a name, a schema and a function of the sample, which `_drawn_topics` yields:

| topic | schema | what |
|---|---|---|
| `/{finger}/tip_in_world` | foxglove.PoseInFrame | the estimated tip |
| `/{finger}/shape` | foxglove.SceneUpdate | the estimated finger, and the estimated contact force |
| `/{finger}/true_shape` | foxglove.SceneUpdate | the simulated finger |
| `/{object}/in_world` | foxglove.PoseInFrame | an object |
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.spatial.transform import Rotation

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.finger_drawing import (
    LENGTH,
    MIN_FORCE,
    drawn_signals,
    estimated_corners,
    force_in_world,
    link_frames,
    to_world,
)
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners

_NS_PER_S = 10**9  # ns
_ENTITY_COLORS = {"shape": (0.88, 0.62, 0.0), "true_shape": (0.45, 0.1, 0.5), "force": (0.8, 0.1, 0.1)}
_LINE_THICKNESS = 4e-3  # m, of lines and arrows
_MAX_NUMBERS = 100  # of a signal in a sample
_PLOT_GROUPS = (  # signals of a finger, a plot of each group
    ("strain", "curvature", "orientation"),
    ("pressure", "sampled_pressure", "pressure_command"),
    ("transverse_force", "true_transverse_force"),
    ("contact_arc_length", "true_contact_arc_length"),
)

Make = Callable[[int], dict[str, Any] | None]  # the message of a sample; None: there is none


def write_mcap(data: xr.Dataset, path: Path) -> None:
    """Writes a recording, and beside it `{name}.layout.json`, a layout for it.

    Raises:
        InputError: if it cannot be written, or mcap is missing.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        expected = "MCAP files require mcap: pip install 'soft-gripper[ros]'"
        raise InputError(path, "file", path.name, expected) from None
    stamps = [round(float(t) * _NS_PER_S) for t in data["time"].values]
    with atomic_file(path) as partial, partial.open("wb") as file:
        writer = Writer(file)
        writer.start(library="soft-gripper")
        writer.add_metadata("run", {str(name): str(value) for name, value in data.attrs.items()})
        topics = [*_signal_topics(data), *_drawn_topics(data)]
        channels = dict[str, int]()
        for i, stamp in enumerate(stamps):  # in the order of time: readers then need one chunk at a time
            for topic, schema, make_content in topics:
                if (content := make_content(i)) is None:
                    continue
                message = {**_header(stamp, schema), **content}
                if topic not in channels:
                    text = json.dumps(_schema(message, schema)).encode()
                    schema_id = writer.register_schema(schema, "jsonschema", text)
                    channels[topic] = writer.register_channel(topic, "json", schema_id)
                writer.add_message(channels[topic], stamp, json.dumps(message).encode(), stamp)
        writer.finish()  # type: ignore[no-untyped-call]
    with atomic_file(path.with_suffix(".layout.json")) as partial:
        partial.write_text(json.dumps(layout(data), indent=1), encoding="utf-8")


def layout(data: xr.Dataset) -> dict[str, Any]:
    """A layout of Foxglove: the fingers in space, and plots of their readings, pressures, and contacts."""
    visible_topics = {topic: {"visible": True} for topic, *_ in _drawn_topics(data)}
    grid = {"layerId": "foxglove.Grid", "instanceId": "grid", "visible": True, "size": 1, "divisions": 20}
    panels: dict[str, Any] = {"3D!space": {"topics": visible_topics, "layers": {"grid": grid}, "followTf": "world"}}
    for group in _PLOT_GROUPS:
        paths = [path for name in _fingers(data) for signal in group for path in _value_paths(data, f"{name}.{signal}")]
        if paths:
            lines = [{"value": path, "enabled": True, "timestampMethod": "receiveTime"} for path in paths]
            panels[f"Plot!{group[0]}"] = {"title": group[0].replace("_", " "), "paths": lines, "isSynced": True}
    _, *plots = panels
    tree = {"first": "3D!space", "second": _stack_panels(plots), "direction": "row", "splitPercentage": 60}
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": tree if plots else "3D!space",
    }


def _stack_panels(panels: list[str]) -> Any:
    """Stacks panels of equal height."""
    if len(panels) < 2:
        return panels[0] if panels else None
    first, *other_panels = panels
    percentage = 100 / len(panels)
    return {"first": first, "second": _stack_panels(other_panels), "direction": "column", "splitPercentage": percentage}


def _value_paths(data: xr.Dataset, name: str) -> list[str]:
    """Message paths of the numbers of a signal."""
    if name not in data:
        return []
    paths = [f"{_topic(name)}.value"]
    for axis in (data[dim].values.tolist() for dim in data[name].dims[1:]):
        suffixes = [f".{label}" if isinstance(label, str) else f"[{i}]" for i, label in enumerate(axis)]
        paths = [path + suffix for path in paths for suffix in suffixes]
    return paths


def _topic(name: str) -> str:
    return "/" + name.replace(".", "/")


def _fingers(data: xr.Dataset) -> list[str]:
    return [str(name).removesuffix(".X_WB") for name in data.data_vars if str(name).endswith(".X_WB")]


def _signal_topics(data: xr.Dataset) -> Iterator[tuple[str, str, Make]]:
    """Yields topics of all signals, their schemas, and functions that make their messages."""
    for key in data.data_vars:
        name = str(key)
        values = data[name]
        if values[0].size > _MAX_NUMBERS:
            continue
        labels = [data[dim].values.tolist() for dim in values.dims[1:]]
        numbers = values.values

        def make(i: int, numbers: Array = numbers, labels: list[list[Any]] = labels) -> dict[str, Any]:
            return {"value": _label_values(numbers[i].tolist(), labels)}

        yield _topic(name), name, make


def _label_values(values: Any, labels: list[list[Any]]) -> Any:
    """Nests numbers as a message: entries along an axis are named by its labels if these are texts."""
    if not labels:
        return values if math.isfinite(values) else None
    entries = [_label_values(value, labels[1:]) for value in values]
    return dict(zip(labels[0], entries, strict=True)) if isinstance(labels[0][0], str) else entries


def _drawn_topics(data: xr.Dataset) -> Iterator[tuple[str, str, Make]]:
    """Yields drawn topics, their schemas, and functions that make their messages."""
    for name in _fingers(data):
        signals = {str(key).removeprefix(f"{name}."): value.values for key, value in data.items()}
        X_WB = signals["X_WB"]
        if drawn_signals(signals):
            in_B = estimated_corners(signals)
            points = to_world(X_WB, in_B)
            rotations = X_WB[:, :, :3] @ link_frames(in_B)[:, -1]
            yield f"/{name}/tip_in_world", "foxglove.PoseInFrame", _pose(points[:, -1], _quaternions(rotations))
            yield f"/{name}/shape", "foxglove.SceneUpdate", _scene(name, "shape", points, force_in_world(signals, in_B))
        if {TRUE_JOINTS, TRUE_TIP} <= signals.keys():
            points = to_world(X_WB, corners(signals[TRUE_JOINTS], signals[TRUE_TIP]))
            yield f"/{name}/true_shape", "foxglove.SceneUpdate", _scene(name, "true_shape", points, None)
    for key in data.data_vars:
        if str(key).endswith(".pose") and data[key].shape[1:] == (7,):
            pose = data[key].values
            topic = f"/{str(key).removesuffix('.pose')}/in_world"
            yield topic, "foxglove.PoseInFrame", _pose(pose[:, 4:], np.roll(pose[:, :4], -1, axis=1))


def _quaternions(R: Array) -> Array:
    """Quaternions x, y, z, w of rotations (T, 3, 3), (T, 4); NaN where these are."""
    xyzw: Array = np.full((len(R), 4), np.nan)
    is_known = np.isfinite(R).all(axis=(1, 2))
    xyzw[is_known] = Rotation.from_matrix(R[is_known]).as_quat()
    return xyzw


def _pose(p: Array, xyzw: Array) -> Make:
    def make(i: int) -> dict[str, Any] | None:
        if not np.isfinite(p[i]).all():
            return None
        return {"pose": {"position": _xyz(p[i]), "orientation": dict(zip("xyzw", xyzw[i].tolist(), strict=True))}}

    return make


def _scene(name: str, kind: str, points: Array, forces: tuple[Array, Array] | None) -> Make:
    def make(i: int) -> dict[str, Any] | None:
        if not np.isfinite(points[i]).all():
            return None
        line = {
            "type": 0,  # a strip
            "pose": _IDENTITY_POSE,
            "thickness": _LINE_THICKNESS,
            "scale_invariant": False,
            "points": [_xyz(p) for p in points[i]],
            "color": _color(kind),
            "colors": [],
            "indices": [],
        }
        entity = {
            "timestamp": {"sec": 0, "nsec": 0},
            "frame_id": "world",
            "id": f"{name} {kind}",
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": False,
            "metadata": [],
            "lines": [line],
            "arrows": [] if forces is None else _arrow(forces[0][i], forces[1][i]),
        }
        empty_lists = {kind: list[Any]() for kind in ("cubes", "spheres", "cylinders", "triangles", "texts", "models")}
        return {"deletions": [], "entities": [entity | empty_lists]}

    return make


_IDENTITY_POSE = {"position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}


def _arrow(tip: Array, force: Array) -> list[Any]:
    """Arrow whose tip is at the point of a force, N; none if the force is small or unknown."""
    size = float(np.linalg.norm(force))
    if not size > MIN_FORCE or not np.isfinite(tip).all():
        return []
    rotation, _ = Rotation.align_vectors([force / size], [[1, 0, 0]])  # an arrow points along x
    length = LENGTH * size
    head = 2 * _LINE_THICKNESS
    return [
        {
            "pose": {
                "position": _xyz(tip - force / size * (length + head)),
                "orientation": dict(zip("xyzw", rotation.as_quat().tolist(), strict=True)),
            },
            "shaft_length": length,
            "shaft_diameter": _LINE_THICKNESS,
            "head_length": head,
            "head_diameter": 2 * _LINE_THICKNESS,
            "color": _color("force"),
        }
    ]


def _color(kind: str) -> dict[str, float]:
    return dict(zip("rgba", (*_ENTITY_COLORS[kind], 1.0), strict=True))


def _xyz(p: Array) -> dict[str, float]:
    return dict(zip("xyz", p.tolist(), strict=True))


def _header(stamp: int, schema: str) -> dict[str, Any]:
    time = {"timestamp": {"sec": stamp // _NS_PER_S, "nsec": stamp % _NS_PER_S}}
    frame = {"frame_id": "world"} if schema == "foxglove.PoseInFrame" else {}
    return {} if schema == "foxglove.SceneUpdate" else {**time, **frame}


_JSON_TYPES: Mapping[type, str] = {str: "string", bool: "boolean", int: "integer", float: "number"}


def _schema(value: Any, title: str = "") -> dict[str, Any]:
    """Derives the JSON schema of a message from an example."""
    head: dict[str, Any] = {"title": title} if title else {}
    if isinstance(value, dict):
        return {**head, "type": "object", "properties": {name: _schema(entry) for name, entry in value.items()}}
    if isinstance(value, list):
        return {**head, "type": "array", "items": _schema(value[0]) if value else {"type": "object"}}
    return {**head, "type": _JSON_TYPES.get(type(value), "number")}
