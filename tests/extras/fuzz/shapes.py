"""Files of the shapes that cost a reader most, for every kind of text: deep, wide, long, in themselves, endless."""

import json
from collections.abc import Callable

from inputs import ADDS, FINGER, SCENARIO, Input, directives_input, log_input, scenario_input

COUNT = 200_000  # values: many times as many as any file has
DEPTH = 100_000
TEXT = "x" * 10_000_000
SPARSE, DEVICE = 2**40, "/dev/zero"  # bytes; a device

Shapes = dict[str, Callable[[], Input]]


def _object(suffix: str, text: str) -> Input:
    """A scenario with a model of a kind of file."""
    scenario = {**SCENARIO, "models": [SCENARIO["models"][0], {**SCENARIO["models"][1], "file": f"thing.{suffix}"}]}
    return scenario_input(text, f"thing.{suffix}", scenario, "show")


def _endless(whole: Input, name: str) -> Shapes:
    """The same input with a file that has no end, a sparse one, and a pointer of Git LFS in its place."""

    def instead(content: bytes | int | str) -> Callable[[], Input]:
        return lambda: Input(whole.files | {name: content}, whole.arguments)

    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 5\n"
    return {"endless": instead(DEVICE), "sparse": instead(SPARSE), "pointer": instead(pointer)}


def _yaml(make: Callable[[str], Input], key: str) -> Shapes:
    laughs = "a0: &a0 [1]\n" + "".join(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(12))
    merges = "a0: &a0 {k: 1}\n"
    merges += "".join(f"a{i + 1}: &a{i + 1} {{<<: [{', '.join([f'*a{i}'] * 9)}]}}\n" for i in range(12))
    return {
        "deep": lambda: make(f"{key}: {'[' * DEPTH}{']' * DEPTH}"),
        "deep mappings": lambda: make(f"{key}: {'{a: ' * DEPTH}1{'}' * DEPTH}"),
        "wide": lambda: make(f"{key}: [{'1, ' * COUNT}1]"),
        "wide mapping": lambda: make(f"{key}:\n" + "".join(f"  k{i}: 1\n" for i in range(30_000))),
        "long": lambda: make(f"{key}: {TEXT}"),
        "long key": lambda: make(f"? {TEXT}\n: 1"),
        "long number": lambda: make(f"{key}: 1{':1' * 24_000}"),
        "in itself": lambda: make(f"{key}: &a [*a]"),
        "laughs": lambda: make(f"{laughs}{key}: *a12"),
        "merges": lambda: make(f"{merges}{key}: *a12"),
    }


def _xml(make: Callable[[str], Input], begin: str, end: str, include: str) -> Shapes:
    return {
        "deep": lambda: make(f"{begin}{'<a>' * DEPTH}{'</a>' * DEPTH}{end}"),
        "wide": lambda: make(f"{begin}{'<a/>' * COUNT}{end}"),
        "long": lambda: make(f"{begin}<a>{TEXT}</a>{end}"),
        "long name": lambda: make(f"{begin}<a name='{TEXT[:60_000]}'/>{end}"),
        "comments": lambda: make(f"{begin}{'<!--' * COUNT}{end}"),
        "prefixes": lambda: make(begin + "".join(f"<p{i}:a/>" for i in range(50_000)) + end),
        "in itself": lambda: make(f"{begin}{include}{end}"),
    }


def _table(text: str) -> Input:
    return log_input((text.encode(), ""), "")


_HEAD = "t,a,b,c,d,p\n"
_ROW = "0,1,2,3,4,5\n"
_TABLES: Shapes = {
    "deep": lambda: _table('{"t": ' * DEPTH + "1" + "}" * DEPTH),
    "wide": lambda: _table(f"{_HEAD}{'1,' * COUNT}\n"),
    "wide head": lambda: _table(",".join(map(str, range(COUNT))) + "\n" + _ROW),
    "long": lambda: _table(f"{_HEAD}{TEXT}\n"),
    "long quote": lambda: _table(f'{_HEAD}"{TEXT}\n'),
    "blanks": lambda: _table(_HEAD + "".join(f"{i / 100},1,2,3,4,5{' ' * 2000}\n" for i in range(500))),
}


def _gltf(**parts: object) -> Input:
    return _object("gltf", json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]} | parts))


_PLAIN = scenario_input(FINGER, "finger.urdf", SCENARIO, "show")
_MJCF = _object("xml", "")
_MESHES: dict[str, Shapes] = {
    "obj": {
        "wide": lambda: _object("obj", "v 0 0 0\n" * COUNT + "f 1 2 3\n" * COUNT),
        "wide face": lambda: _object("obj", "v 0 0 0\n" * 3 + f"f {'1 ' * COUNT}\n"),
        "long": lambda: _object("obj", f"v {TEXT}\n"),
        "in itself": lambda: _object("obj", "mtllib thing.obj\nv 0 0 0\n"),
    },
    "stl": {
        "deep": lambda: _object("stl", "solid a\n" * DEPTH),
        "wide": lambda: _object("stl", "solid a\n" + "facet normal 0 0 0\nouter loop\n" * COUNT),
        "long": lambda: _object("stl", f"solid {TEXT}"),
        "count": lambda: _object("stl", "\0" * 80 + "\x7f" * 4),
    },
    "gltf": {
        "deep": lambda: _object("gltf", '{"a":' * DEPTH + "1" + "}" * DEPTH),
        "wide": lambda: _gltf(nodes=[{"mesh": 0}] * COUNT),
        "long": lambda: _gltf(nodes=[{"name": TEXT}]),
        "in itself": lambda: _gltf(nodes=[{"children": [0]}]),
        "count": lambda: _gltf(
            nodes=[{"mesh": 0}],
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
            accessors=[{"bufferView": 0, "componentType": 5126, "count": 10**9, "type": "VEC3"}],
            bufferViews=[{"buffer": 0, "byteLength": 12 * 10**9}],
            buffers=[{"byteLength": 12 * 10**9, "uri": "data:application/octet-stream;base64,AAAA"}],
        ),
    },
}


SHAPES: dict[str, Shapes] = {
    "yaml": _yaml(lambda text: scenario_input(text, "scenario.yaml", {}, "show"), "gravity")
    | _endless(_PLAIN, "scenario.yaml"),
    "directives": _yaml(directives_input, "directives")
    | _endless(scenario_input("", "a.dmd.yaml", ADDS, "show"), "a.dmd.yaml"),
    "urdf": _xml(lambda text: _object("urdf", text), "<robot name='r'>", "</robot>", "<include file='thing.urdf'/>")
    | _endless(_object("urdf", ""), "thing.urdf"),
    "sdf": _xml(
        lambda text: _object("sdf", text),
        "<sdf version='1.9'><model name='m'><link name='l'/>",
        "</model></sdf>",
        "<include><uri>thing.sdf</uri></include>",
    )
    | _endless(_object("sdf", ""), "thing.sdf"),
    "mjcf": _xml(
        lambda text: _object("xml", text),
        "<mujoco model='m'><worldbody><body name='b'><geom size='0.01'/>",
        "</body></worldbody></mujoco>",
        "<include file='thing.xml'/>",
    )
    | _endless(_MJCF, "thing.xml"),
    "csv": _TABLES | _endless(_table(""), "log.csv"),
} | {suffix: shapes | _endless(_object(suffix, ""), f"thing.{suffix}") for suffix, shapes in _MESHES.items()}
