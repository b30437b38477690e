"""Files with every kind of damage, the same from the same seed: of arrays (npz) and of recordings (netCDF)."""

import gzip
import io
import warnings
import zipfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.lib import format as npy

# What may stand where a number is expected.
NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-308, 5e-324, -0.0, -1.0)


def damaged_bytes(content: bytes, seed: int) -> bytes:
    """The content with bits flipped, or a part cut, overwritten, doubled or inserted, once or a few times."""
    rng = np.random.default_rng(seed)
    for _ in range(rng.integers(1, 4)):
        begin = int(rng.integers(0, len(content) + 1))
        begin = begin if rng.integers(2) else min(begin, 400)  # headers are in front
        length = int(rng.choice([1, 1, 2, 4, 8, 100]))
        part = content[begin : begin + length]
        between = [
            lambda part=part: bytes(byte ^ (1 << int(rng.integers(8))) for byte in part),
            lambda: b"",
            lambda part=part: 2 * part,
            lambda length=length: rng.bytes(length),
            lambda part=part: bytes(len(part)),
            lambda part=part: len(part) * b"\xff",
        ][rng.integers(6)]()
        content = content[:begin] + between + content[begin + length :]
        if rng.integers(4) == 0:
            content = content[: int(rng.integers(0, len(content) + 1))]
    return content


def archive(members: list[tuple[str, bytes]], **options: Any) -> bytes:
    """A zip file of members, of which several may have one name."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, **options) as opened, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of names that are there twice
        for name, content in members:
            opened.writestr(name, content)
    return file.getvalue()


def as_npy(values: Any, shape: str = "") -> bytes:
    """A member of an npz file; with `shape`, text of a shape that its header announces in the place of the true one."""
    file = io.BytesIO()
    npy.write_array(file, np.asanyarray(values), allow_pickle=True)
    content = file.getvalue()
    if not shape:
        return content
    begin = content.index(b"'shape': ") + 9
    end = content.index(b")", begin) + 1
    header = content[10:begin] + shape.encode() + content[end:]
    body = header.index(b"\n") + 1
    return content[:8] + (body).to_bytes(2, "little") + header


_OF_AN_ARRAY: dict[str, Callable[[Any], Any]] = {
    "no contacts": lambda values: values[:0],
    "one more": lambda values: np.concatenate([values, values[:1]]),
    "one axis more": lambda values: values[..., None],
    "one number": lambda values: values[0].ravel()[0],
    "transposed": lambda values: np.stack([values, values]).T,
    "objects": lambda values: values.astype(object),
    "dates": lambda values: np.zeros(values.shape, "M8[s]"),
    "records": lambda values: np.zeros(values.shape, [("a", float), ("b", int)]),
    "bytes": lambda values: np.full(values.shape, b"1.0"),
    "text": lambda values: np.full(values.shape, "upside"),
    "truth": lambda values: np.ones(values.shape, bool),
    "whole numbers": lambda values: np.ones(values.shape, int),
    "complex": lambda values: np.full(values.shape, 1e300j),
}
_SHAPES = ("(10**9,)", "(1000000000, 12)", "(-1,)", "(4294967296, 4294967296)", "(1.5,)", "()", "(True,)", "(" * 200)


def damaged_archives(arrays: dict[str, Any], seed: int) -> Iterator[tuple[str, bytes]]:
    """Damaged files of arrays: what was done, and the content."""
    whole = {f"{name}.npy": as_npy(values) for name, values in arrays.items()}
    for name, values in arrays.items():
        yield from _with_another_member(whole, name, values)
        for how, content in _damaged_arrays(values):
            yield f"{name}: {how}", archive(list({**whole, f"{name}.npy": content}.items()))
    yield from _damaged_zip(arrays, whole, seed)


def _with_another_member(whole: dict[str, bytes], name: str, values: Any) -> Iterator[tuple[str, bytes]]:
    own = whole[f"{name}.npy"]
    others = [(member, content) for member, content in whole.items() if member != f"{name}.npy"]
    yield f"without {name}", archive(others)
    yield f"{name} renamed", archive([*others, (f"{name}.txt", own)])
    yield f"{name} twice", archive([*whole.items(), (f"{name}.npy", as_npy(values[:1]))])
    for how, content in {"empty": b"", "in half": own[:-5]}.items():
        yield f"{name} {how}", archive(list({**whole, f"{name}.npy": content}.items()))


def _damaged_arrays(values: Any) -> Iterator[tuple[str, bytes]]:
    for how, change in _OF_AN_ARRAY.items():
        yield how, as_npy(change(values))
    for shape in _SHAPES:
        yield shape[:20], as_npy(values, shape)
    for number in NUMBERS if values.dtype.kind in "fc" else ():
        spoilt = values.copy()
        spoilt.flat[0] = number
        yield str(number), as_npy(spoilt)


def _damaged_zip(arrays: dict[str, Any], whole: dict[str, bytes], seed: int) -> Iterator[tuple[str, bytes]]:
    first, content = next(iter(arrays)), archive(list(whole.items()))
    large = {f"{first}.npy": as_npy(np.zeros(10_000_000))}
    newer = {f"{first}.npy": whole[f"{first}.npy"].replace(b"NUMPY\x01", b"NUMPY\x03", 1)}
    yield "one more array", archive([*whole.items(), ("more.npy", as_npy([1.0]))])
    yield "a member outside", archive([*whole.items(), ("../../x.npy", as_npy([1.0]))])
    yield "no arrays", archive([])
    yield "a bomb", archive(list({**whole, **large}.items()))
    yield "version 3 of npy", archive(list({**whole, **newer}.items()))
    yield "a pickle", as_npy(np.array([{}], object))
    yield "a single array", as_npy(arrays[first])
    yield "nothing", b""
    yield "text", b"side,force\ninner,1.0\n"
    yield "a zip in front of which stands text", b"x" * 1000 + content
    for i in range(60):
        yield f"bytes {i}", damaged_bytes(content, seed + i)


_OF_A_SIGNAL: dict[str, Callable[[Any], Any]] = {
    "one axis more": lambda signal: signal.expand_dims("more", axis=-1),
    "one axis less": lambda signal: signal[..., 0],
    "one number": lambda signal: signal.mean(),
    "transposed": lambda signal: signal.transpose(*reversed(signal.dims)),
    "whole numbers": lambda signal: signal.fillna(0).astype("i4"),
    "text": lambda signal: signal.astype("S3"),
}


def damaged_recordings(data: Any, signals: list[str], seed: int) -> Iterator[tuple[str, bytes]]:
    """Damaged files of a recording, an xarray Dataset of which `signals` are read: what was done, and the content."""
    for changed in (
        *(_with_other_signal(data, name) for name in signals),
        _with_other_time(data),
        _with_other_scenario(data),
    ):
        for how, found in changed:
            yield how, _netcdf(found)
    yield from _damaged_netcdf(_netcdf(data), seed)


def _netcdf(data: Any) -> bytes:
    return bytes(data.to_netcdf(engine="scipy"))


def _with_other_signal(data: Any, name: str) -> Iterator[tuple[str, Any]]:
    yield f"without {name}", data.drop_vars(name)
    for how, change in _OF_A_SIGNAL.items():
        if data[name].ndim > 1 or how != "one axis less":
            yield f"{name}: {how}", data.drop_vars(name).assign({name: change(data[name])})
    for number in NUMBERS:
        spoilt = data[name].copy(deep=True)
        spoilt.values[len(spoilt) // 2] = number
        yield f"{name}: {number}", data.drop_vars(name).assign({name: spoilt})


def _with_other_time(data: Any) -> Iterator[tuple[str, Any]]:
    time, late = data["time"].values, np.arange(data.sizes["time"]) > data.sizes["time"] // 2
    for how, times in {
        "backwards": time[::-1],
        "at a stand": 0 * time,
        "a gap": time + 1e9 * late,
        "not from 0 on": time + 5.0,
        "NaN": np.where(late, np.nan, time),
        "slow": 1e3 * time,
        "huge": 1e308 * np.sign(time),
        "dates": time.astype(int).astype("M8[D]"),
    }.items():
        yield f"time: {how}", data.assign_coords(time=("time", times))
    yield "without time", data.drop_vars("time")
    for how, samples in {"no samples": 0, "one sample": 1, "half of the samples": len(time) // 2}.items():
        yield how, data.isel(time=slice(0, samples))


_SCENARIOS = {
    "empty": "",
    "a number": 1.5,
    "no mapping": "[1, 2]",
    "not YAML": "a: [",
    "of nothing": "models: []",
    "in Latin": b"models: \xe9",
    "another": "models: [{name: a, file: none.urdf}]",
}


def _with_other_scenario(data: Any) -> Iterator[tuple[str, Any]]:
    for how, text in _SCENARIOS.items():
        yield f"scenario: {how}", data.assign_attrs(scenario=text)
    yield "without a scenario", data.drop_attrs()


def _damaged_netcdf(content: bytes, seed: int) -> Iterator[tuple[str, bytes]]:
    yield "nothing", b""
    yield "text", b"time,strain\n0,1\n"
    yield "HDF5", b"\x89HDF\r\n\x1a\n" + bytes(1000)
    yield "gzip", gzip.compress(content)
    yield "netCDF 5", b"CDF\x05" + content[4:]
    for length in (3, 4, 8, 12, 100, 1000, len(content) // 2, len(content) - 1):
        yield f"{length} bytes of it", content[:length]
    for place in range(4, 120, 4):  # numbers of the header: of samples, lengths of axes, kinds, counts
        for number in (b"\x7f\xff\xff\xff", b"\0\0\0\0"):
            yield f"{number.hex()} at {place}", content[:place] + number + content[place + 4 :]
    for i in range(60):
        yield f"bytes {i}", damaged_bytes(content, seed + i)
